"""XML and YAML entities: typed attributes, children, and unread attributes."""

from __future__ import annotations

from io import StringIO
from typing import Any, List  # noqa: UP035 - List[...] is the API

import pytest

from launcher.base.errors import LaunchFileError
from launcher.language.frontends.entity import Entity
from launcher.language.frontends.xml import XmlParser
from launcher.language.frontends.yaml import YamlParser


def from_xml(text: str) -> Entity:
    """The root entity of an XML text."""
    return XmlParser.load(StringIO(text))[0]


def from_yaml(text: str) -> Entity:
    """The root entity of a YAML text."""
    return YamlParser.load(StringIO(text))[0]


COERCED: list[tuple[str, Any, Any]] = [
    ("5", str, "5"),
    ("5", int, 5),
    ("5", float, 5.0),
    ("true", bool, True),
    ("no", bool, False),
    ("perhaps", bool, "perhaps"),
    ("$(var a)", bool, "$(var a)"),
    ("$(var a)", float, "$(var a)"),
    ("many", int, "many"),
    ("5", None, 5),
    ("5.0", None, 5.0),
    ("'5'", None, "5"),
    ("word", None, "word"),
    ("[1, 2]", None, [1, 2]),
    ("[1, $(var x)]", None, [1, "$(var x)"]),
    ("[unclosed", None, "[unclosed"),
    ("[1, 2]", List[int], [1, 2]),  # noqa: UP006
    ("[1, x]", List[int], [1, "x"]),  # noqa: UP006
    ("[a]", List[str], ["a"]),  # noqa: UP006
    ("[]", List[float], []),  # noqa: UP006
    ("", None, ""),
    ("", bool, ""),
    ("1", bool, True),
    ("0", bool, False),
]


@pytest.mark.parametrize(("text", "data_type", "value"), COERCED)
def test_xml_attribute_is_coerced(text: str, data_type: Any, value: Any) -> None:
    found = from_xml(f'<a b="{text}"/>').get_attr("b", data_type=data_type)
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    ("text", "data_type", "can_be_str"),
    [
        ("many", int, False),
        ("perhaps", bool, False),
        ("1", List[int], True),  # noqa: UP006
        ("[1, a, 2.5]", None, True),
        ("{a: 1}", None, True),
        ("~", None, True),
        ("[[1]]", None, True),
        ("[1, 2.5]", List[int], True),  # noqa: UP006
    ],
)
def test_xml_attribute_of_another_type_is_a_type_error(
    text: str, data_type: Any, can_be_str: bool
) -> None:
    entity = from_xml(f'<a b="{text}"/>')
    with pytest.raises(TypeError):
        entity.get_attr("b", data_type=data_type, can_be_str=can_be_str)


def test_xml_attribute_is_split_at_its_separator() -> None:
    entity = from_xml('<a b="1;2" b-sep=";" c="x, y" c-sep=", "/>')
    assert entity.get_attr("b", data_type=None) == [1, 2]
    assert entity.get_attr("c", data_type=List[str]) == ["x", "y"]  # noqa: UP006
    entity.assert_entity_completely_parsed()


def test_xml_list_for_a_scalar_is_a_type_error() -> None:
    with pytest.raises(TypeError):
        from_xml('<a b="1,2" b-sep=","/>').get_attr("b", data_type=int)


def test_nested_xml_entities_come_in_order() -> None:
    entity = from_xml("<a><b n='1'/><c/><b n='2'/></a>")
    nested = entity.get_attr("b", data_type=List[Entity])  # noqa: UP006
    assert [one.get_attr("n") for one in nested] == ["1", "2"]
    assert [child.type_name for child in entity.children] == ["b", "c", "b"]
    assert entity.get_attr("d", data_type=List[Entity], optional=True) is None  # noqa: UP006


@pytest.mark.parametrize("load", [from_xml, from_yaml])
def test_missing_attribute_is_an_attribute_error_unless_it_is_optional(load: Any) -> None:
    entity = load("<a x='1'/>" if load is from_xml else "a: {x: '1'}")
    assert entity.get_attr("y", optional=True) is None
    with pytest.raises(AttributeError):
        entity.get_attr("y")
    with pytest.raises(AttributeError):
        entity.get_attr("y", data_type=List[Entity])  # noqa: UP006


def test_unread_xml_attribute_is_reported_with_its_place_and_a_suggestion() -> None:
    entity = from_xml('<node\n   pkg="p"\n   nmae="n"/>')
    entity.get_attr("pkg")
    entity.get_attr("name", optional=True)
    with pytest.raises(ValueError, match="nmae") as caught:
        entity.assert_entity_completely_parsed()
    assert isinstance(caught.value, LaunchFileError)
    assert caught.value.render().splitlines()[1:] == [
        '       nmae="n"/>',
        "       ^",
        "hint: did you mean 'name'?",
    ]


def test_unread_xml_tag_is_reported_with_its_line() -> None:
    entity = from_xml("<node>\n  <parm/></node>")
    entity.get_attr("param", data_type=List[Entity], optional=True)  # noqa: UP006
    with pytest.raises(ValueError, match="parm") as caught:
        entity.assert_entity_completely_parsed()
    assert isinstance(caught.value, LaunchFileError)
    assert (caught.value.column, caught.value.source_line) == (3, "  <parm/></node>")


def test_xml_namespaces_are_kept_as_elementtree_keeps_them() -> None:
    entity = from_xml('<a xmlns:x="urn:x" x:b="1"><x:c/></a>')
    assert entity.get_attr("{urn:x}b") == "1"
    assert entity.children[0].type_name == "{urn:x}c"


YAML_VALUES: list[tuple[str, Any, Any]] = [
    ("text", str, "text"),
    ("'5'", str, "5"),
    ("5", int, 5),
    ("2.5", float, 2.5),
    ("true", bool, True),
    ("$(var a)", bool, "$(var a)"),
    ("[1, 2]", List[int], [1, 2]),  # noqa: UP006
    ("[1, a]", None, [1, "a"]),
    ("[]", None, []),
    ("1", None, 1),
]


@pytest.mark.parametrize(("text", "data_type", "value"), YAML_VALUES)
def test_yaml_value_of_the_type_is_taken_as_it_is(text: str, data_type: Any, value: Any) -> None:
    found = from_yaml(f"a: {{b: {text}}}").get_attr("b", data_type=data_type)
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    ("text", "data_type"),
    [("5", str), ("true", str), ("5", float), ("null", None), ("[1, a, 2.5]", None), ("{}", str)],
)
def test_yaml_value_of_another_type_is_a_type_error(text: str, data_type: Any) -> None:
    with pytest.raises(TypeError):
        from_yaml(f"a: {{b: {text}}}").get_attr("b", data_type=data_type)


@pytest.mark.parametrize("text", ["5", "on", "0x10", "1.50"])
def test_yaml_number_for_a_string_gets_the_advice_to_quote_it(text: str) -> None:
    with pytest.raises(TypeError) as caught:
        from_yaml(f"arg:\n  name: n\n  default: {text}").get_attr("default")
    assert isinstance(caught.value, LaunchFileError)
    assert caught.value.where == "<string>:3" or str(caught.value.where).endswith(":3")
    assert caught.value.hint == f'quote it: "{text}"'


def test_yaml_children_are_the_list_or_the_key_children() -> None:
    for text in ("a: [{b: {}}, {c: []}]", "a: {children: [{b: {}}, {c: []}]}"):
        entity = from_yaml(text)
        assert [child.type_name for child in entity.children] == ["b", "c"]
        entity.assert_entity_completely_parsed()


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("a: {b: {}}", ValueError),
        ("a: text", TypeError),
        ("a: [{b: {}, c: {}}]", RuntimeError),
        ("a: [text]", RuntimeError),
        ("a: [null]", TypeError),
        ("a: {children: 5}", TypeError),
    ],
)
def test_yaml_children_of_the_wrong_shape_are_refused(text: str, kind: type[Exception]) -> None:
    with pytest.raises(kind) as caught:
        _ = from_yaml(text).children
    assert isinstance(caught.value, LaunchFileError)


def test_unexpected_yaml_list_is_a_value_error() -> None:
    with pytest.raises(ValueError, match="list of actions"):
        from_yaml("a: [{b: {}}]").assert_entity_completely_parsed()


def test_yaml_entity_without_a_value_is_a_type_error() -> None:
    with pytest.raises(TypeError):
        from_yaml("a:").get_attr("if", optional=True)


def test_yaml_nested_entities_are_a_list_of_mappings() -> None:
    nested = from_yaml("a: {b: [{n: '1'}, {n: '2'}]}").get_attr("b", data_type=List[Entity])  # noqa: UP006
    assert [one.get_attr("n") for one in nested] == ["1", "2"]
    for wrong in ("a: {b: {n: '1'}}", "a: {b: []}", "a: {b: [1]}", "a: {b: text}"):
        with pytest.raises(TypeError):
            from_yaml(wrong).get_attr("b", data_type=List[Entity])  # noqa: UP006


def test_merged_and_anchored_yaml_keys_know_their_lines() -> None:
    entity = from_yaml("a:\n  - b: &x {n: '1'}\n  - c:\n      <<: *x\n      m: 5\n")
    merged = entity.children[1]
    assert merged.get_attr("n") == "1"
    with pytest.raises(TypeError) as caught:
        merged.get_attr("m")
    assert isinstance(caught.value, LaunchFileError)
    assert caught.value.source_line == "      m: 5"


def test_yaml_key_that_occurs_twice_counts_once() -> None:
    entity = from_yaml("a:\n  - b: {n: '1'}\n    b: {n: '2'}\n")
    (child,) = entity.children
    assert child.get_attr("n") == "2"
    assert child.place is not None and child.place.line == 3


LAUGHS = "".join(f"a{n + 1}: &a{n + 1} [{', '.join([f'*a{n}'] * 9)}]\n" for n in range(9))
HOSTILE_YAML = {
    "laughs": "a0: &a0 [x]\n" + LAUGHS,
    "merged laughs": "a0: &a0 {x: 1}\n"
    + "".join(f"a{n + 1}: &a{n + 1} {{<<: [{', '.join([f'*a{n}'] * 9)}]}}\n" for n in range(9)),
    "deep": "[" * 10_000,
    "deep blocks": "".join(" " * n + "a:\n" for n in range(400)),
    "endless": "a: &a [*a]",
    "long number": "a: " + "9" * 10_000,
    "long number to base 60": "a: " + "1:" * 100_000 + "1",
    "bad date": "a: 2001-99-99",
    "bad tag": "a: !!python/object:os.system {}",
    "bad character": "a: \x01",
    "two documents": "a: 1\n---\nb: 2",
    "unhashable key": "a: {[1]: 2}",
    "tab": "a:\n\t- b: 1",
    "empty": "",
    "text": "just text",
    "two roots": "a: []\nb: []",
}


@pytest.mark.parametrize("name", HOSTILE_YAML)
def test_hostile_yaml_ends_in_a_clean_error(name: str) -> None:
    with pytest.raises(LaunchFileError):
        YamlParser.load(StringIO(HOSTILE_YAML[name]))


XML_LAUGHS = "".join(f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(9))
HOSTILE_XML = {
    "laughs": f'<!DOCTYPE a [<!ENTITY a0 "ha">{XML_LAUGHS}]><a b="&a9;"/>',
    "long entity": f'<!DOCTYPE a [<!ENTITY x "{"y" * 5000}">]><a b="{"&x;" * 1000}"/>',
    "file entity": '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a>&x;</a>',
    "parameter entity": '<!DOCTYPE a [<!ENTITY % x SYSTEM "file:///etc/passwd"> %x;]><a/>',
    "undefined entity": "<a>&nope;</a>",
    "deep": "<a>" * 100_000,
    "empty": "",
    "text": "just text",
    "two roots": "<a/><b/>",
    "nul": "<a>\x00</a>",
    "twice": '<a b="1" b="2"/>',
    "unclosed": "<a><b></a>",
}


@pytest.mark.parametrize("name", HOSTILE_XML)
def test_hostile_xml_ends_in_a_clean_error(name: str) -> None:
    with pytest.raises(LaunchFileError):
        XmlParser.load(StringIO(HOSTILE_XML[name]))


def test_harmless_xml_entity_is_replaced() -> None:
    entity = from_xml('<!DOCTYPE a [<!ENTITY pkg "demo">]><a b="&pkg;_x"/>')
    assert entity.get_attr("b") == "demo_x"
