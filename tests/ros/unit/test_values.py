"""Parsing of values for messages and parameters."""

from __future__ import annotations

import re

import pytest
import yaml
from rcl_interfaces.msg import ParameterDescriptor
from std_msgs.msg import (
    ByteMultiArray,
    Int8MultiArray,
    Int32,
    Int32MultiArray,
    String,
    UInt8MultiArray,
)

from launcher.base.ros_errors import VerbError
from launcher.ros import parameter_documents, parameter_values
from launcher.ros.messages.from_yaml import fill, parse, value_of

HUGE = 99999999999999999999


@pytest.mark.parametrize(
    "text",
    [
        "a: 2020-13-45",
        "a: !!int x",
        'a: !!int ""',
        "a: !!bool x",
        "a: !!timestamp x",
        "a: " + "9" * 5000,
        "[" * 60_000,
        "- " * 60_000,
        "a: \udcff",
        "{? {a: b}: c}",
    ],
    ids=lambda text: ascii(text[:20]),
)
def test_text_that_is_not_a_value_has_one_kind_of_error(text):
    with pytest.raises(yaml.YAMLError):
        value_of(text)
    with pytest.raises(VerbError, match=r"^The passed value is not YAML: "):
        parse(text)


def test_deeply_nested_values_are_read():
    value = value_of("[" * 90 + "1" + "]" * 90)
    for _ in range(90):
        (value,) = value
    assert value == 1


@pytest.mark.parametrize("message", [Int32, String])
def test_a_number_that_python_does_not_write_is_refused_in_words(message):
    with pytest.raises(VerbError, match=r"'data' takes .*, got a number of thousands of digits"):
        fill(message(), parse("data: 0x" + "f" * 9000))


@pytest.mark.parametrize(
    ("value", "declared", "hint"),
    [
        (HUGE, parameter_values.NOT_SET, "a whole number is from -9223372036854775808 to"),
        (HUGE, parameter_values.BOOL, "a whole number is from"),
        ([1, HUGE], parameter_values.STRINGS, "a whole number is from"),
        (10**400, parameter_values.DOUBLE, "a double is at most"),
        ([1.5, 10**400], parameter_values.NOT_SET, "a double is at most"),
        ([1, 256], parameter_values.BYTES, "a byte is from 0 to 255"),
        ([[1]], parameter_values.NOT_SET, "a parameter is a boolean, number, string, or a list"),
        (None, parameter_values.NOT_SET, "a parameter is a boolean"),
    ],
)
def test_a_parameter_that_cannot_hold_a_value_says_so(value, declared, hint):
    with pytest.raises(VerbError, match=r"^Parameter 'p' cannot hold ") as raised:
        parameter_values.parameter("p", value, declared)
    assert raised.value.hint.startswith(hint)


@pytest.mark.parametrize(
    ("word", "declared", "value"),
    [
        (str(HUGE), parameter_values.NOT_SET, 1e20),  # as rcl reads it
        (str(HUGE), parameter_values.STRING, str(HUGE)),
        ("1e-9", parameter_values.DOUBLE, 1e-9),
        ("[1e-9, 0.0]", parameter_values.DOUBLES, [1e-9, 0.0]),
        ("[.5, 1]", parameter_values.DOUBLES, [0.5, 1.0]),
        ("0x10", parameter_values.INTEGER, 16),
        ("y", parameter_values.BOOL, True),
        ("1_000", parameter_values.NOT_SET, "1_000"),
        ("null", parameter_values.NOT_SET, "null"),
        ("[1, y]", parameter_values.STRINGS, ["1", "y"]),
        ("{a: 1}", parameter_values.NOT_SET, "{a: 1}"),
        ("[1", parameter_values.NOT_SET, "[1"),
        ("", parameter_values.NOT_SET, ""),
    ],
)
def test_a_word_of_the_command_line_is_what_rcl_takes_it_for(word, declared, value):
    held = parameter_values.plain_value(parameter_values.typed_parameter("p", word, declared).value)
    assert (type(held), held) == (type(value), value)


@pytest.mark.parametrize(
    ("given", "declared", "value"),
    [
        (".5", parameter_values.DOUBLE, 0.5),
        ("1e-9", parameter_values.STRING, "1e-9"),
        ("1e-9", parameter_values.NOT_SET, "1e-9"),
        ("0x10", parameter_values.INTEGER, 16),
    ],
)
def test_a_text_of_json_is_a_number_only_where_one_is_declared(given, declared, value):
    held = parameter_values.plain_value(
        parameter_values.plain_parameter("p", given, declared).value
    )
    assert (type(held), held) == (type(value), value)


@pytest.mark.parametrize(
    ("word", "declared", "value"),
    [
        ("5", parameter_values.STRING, 5),
        ("5", parameter_values.DOUBLE, 5),
        ("[1, 2]", parameter_values.STRINGS, [1, 2]),
        ("abc", parameter_values.INTEGER, "abc"),
        ("'5'", parameter_values.STRING, "5"),
    ],
)
def test_a_word_changes_the_type_of_a_parameter_that_may(word, declared, value):
    kind = parameter_values.type_for_words(ParameterDescriptor(type=declared, dynamic_typing=True))
    held = parameter_values.plain_value(parameter_values.typed_parameter("p", word, kind).value)
    assert (type(held), held) == (type(value), value)


@pytest.mark.parametrize(
    ("given", "declared", "value"),
    [
        (5, parameter_values.STRING, 5),
        ("5", parameter_values.STRING, "5"),
        (5, parameter_values.DOUBLE, 5.0),
        ([], parameter_values.DOUBLES, []),
    ],
)
def test_json_changes_the_type_of_a_parameter_that_may(given, declared, value):
    kind = parameter_values.type_for_json(ParameterDescriptor(type=declared, dynamic_typing=True))
    held = parameter_values.plain_value(parameter_values.plain_parameter("p", given, kind).value)
    assert (type(held), held) == (type(value), value)


@pytest.mark.parametrize(
    "type_for", [parameter_values.type_for_words, parameter_values.type_for_json]
)
def test_the_type_of_other_parameters_is_kept(type_for):
    kind = type_for(ParameterDescriptor(type=parameter_values.STRING))
    assert parameter_values.typed_parameter("p", "5", kind).value.string_value == "5"


@pytest.mark.parametrize(
    ("text", "held"),
    [
        ("!!binary AP8=", [b"\x00", b"\xff"]),
        ("[!!binary AA==, !!binary /w==]", [b"\x00", b"\xff"]),
        ("!!binary ''", []),
    ],
)
def test_binary_is_an_array_of_bytes(text, held):
    value = parameter_values.typed_parameter("p", text, parameter_values.NOT_SET).value
    assert (value.type, list(value.byte_array_value)) == (parameter_values.BYTES, held)


@pytest.mark.parametrize(
    ("message", "values"),
    [(UInt8MultiArray, [0, 255]), (ByteMultiArray, [b"\x00", b"\xff"]), (Int8MultiArray, [0, -1])],
)
def test_binary_fills_an_array_of_bytes(message, values):
    made = message()
    fill(made, parse("data: !!binary AP8="))
    assert list(made.data) == values


def test_binary_is_refused_where_there_are_no_bytes():
    with pytest.raises(VerbError, match=r"'data' takes a list, got .* \(!!binary\)"):
        fill(Int32MultiArray(), parse("data: !!binary AP8="))


def test_a_section_of_a_parameter_file_that_holds_itself(tmp_path):
    path = tmp_path / "endless.yaml"
    path.write_text("/n:\n  ros__parameters: &a\n    b: *a\n", encoding="utf-8")
    with pytest.raises(VerbError, match="contains itself"):
        parameter_documents.file_values(str(path), "/n", use_wildcard=False)


SECTIONS = """
/**: {ros__parameters: {speed: 1, group: {a: 1, b: 2}}}
site: {east: {n: {ros__parameters: {speed: 2, group: {a: 3}}}}}
/*/east/n: {ros__parameters: {speed: 3}}
/site/west/n: {ros__parameters: {speed: 4}}
"""


def test_the_sections_of_a_parameter_file_are_those_that_rcl_reads(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(SECTIONS, encoding="utf-8")
    for use_wildcard, expected in (
        (True, {"speed": 2, "group.a": 3, "group.b": 2}),
        (False, {"speed": 2, "group.a": 3}),
    ):
        found = parameter_documents.file_values(
            str(path), "/site/east/n", use_wildcard=use_wildcard
        )
        assert {name: given.value for name, given in found.items()} == expected
    with pytest.raises(VerbError, match="does not contain parameters for /n"):
        parameter_documents.file_values(str(path), "/n", use_wildcard=False)
    assert "speed" in parameter_documents.file_values(str(path), "/n", use_wildcard=True)


@pytest.mark.parametrize(
    ("word", "declared", "value"),
    [
        ("0123", parameter_values.STRING, "0123"),
        ("2026-01-01", parameter_values.STRING, "2026-01-01"),
        ("'0123'", parameter_values.STRING, "0123"),
        ("[0123, y]", parameter_values.STRINGS, ["0123", "y"]),
        ("1e-3", parameter_values.DOUBLE, 0.001),
        ("5", parameter_values.DOUBLE, 5.0),
        ("1e5", parameter_values.NOT_SET, 1e5),
        ("'1e5'", parameter_values.NOT_SET, "1e5"),
        ("[1e-9, 0.0]", parameter_values.DOUBLES, [1e-9, 0.0]),
    ],
)
def test_a_word_of_a_parameter_file_is_read_as_its_parameter(tmp_path, word, declared, value):
    path = tmp_path / "p.yaml"
    path.write_text(f"n: {{ros__parameters: {{p: {word}}}}}", encoding="utf-8")
    (given,) = parameter_documents.file_values(str(path), "/n", use_wildcard=True).values()
    message = parameter_values.written_parameter("p", given, declared)
    assert parameter_values.plain_value(message.value) == value


@pytest.mark.parametrize("content", ["3", "text", "[a, b]"])
def test_a_section_without_names_is_an_error(tmp_path, content):
    path = tmp_path / "p.yaml"
    path.write_text(f"/n: {{ros__parameters: {content}}}", encoding="utf-8")
    expected = f"{path}: expected names of parameters below 'ros__parameters' of '/n'"
    with pytest.raises(VerbError, match=re.escape(expected)):
        parameter_documents.file_values(str(path), "/n", use_wildcard=True)


@pytest.mark.parametrize("content", ["", "{}"])
def test_a_section_may_be_empty(tmp_path, content):
    path = tmp_path / "p.yaml"
    path.write_text(f"/n:\n  ros__parameters: {content}", encoding="utf-8")
    assert parameter_documents.file_values(str(path), "/n", use_wildcard=True) == {}


@pytest.mark.parametrize("text", ["/n:\n  a: [", "/n:\n\ta: 1", "a: b: c", "a: \x07"])
def test_an_error_of_yaml_is_one_line_with_its_place(tmp_path, text):
    path = tmp_path / "p.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(VerbError) as raised:
        parameter_documents.file_values(str(path), "/n", use_wildcard=True)
    place = rf"{re.escape(str(path))}(:[1-3])?"
    assert re.fullmatch(rf"{place}: invalid YAML: (?!.*unicode string).+", raised.value.message)
