"""Fields of every kind, wide strings and actions, in types made by ROS's generator."""

from __future__ import annotations

import contextlib
import io
import json
import sys
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("rclpy")

from hypothesis import HealthCheck, given, settings

from launcher.base.ros_errors import VerbError
from launcher.cli import dispatch as cli
from launcher.ros.messages.form import form
from launcher.ros.messages.from_yaml import fill, parse
from launcher.ros.messages.interfaces import load, load_message
from launcher.ros.messages.to_yaml import Style, to_csv, to_plain, to_yaml
from launcher.ros.verb import to_json_plain
from tests.support.any_message import messages, same
from tests.support.examples import examples
from tests.support.interfaces import PACKAGE, install

pytestmark = pytest.mark.basic  # the generator takes long

KINDS = f"{PACKAGE}/msg/Kinds"


@pytest.fixture(scope="module", autouse=True)
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with contextlib.redirect_stdout(io.StringIO()):
        prefix, python = install(tmp_path_factory.mktemp("every_kind"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMENT_PREFIX_PATH", str(prefix))
        patch.syspath_prepend(python)
        yield
    for name in [name for name in sys.modules if name.partition(".")[0] == PACKAGE]:
        del sys.modules[name]


def shown(*words: str) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert cli.main(words) == 0
    return out.getvalue()


def filled(text: str) -> Any:
    message = load_message(KINDS)()
    fill(message, parse(text))
    return message


def test_values_of_every_kind_survive_the_way_to_yaml_and_back():
    cls = load_message(KINDS)

    @settings(max_examples=examples(80), suppress_health_check=list(HealthCheck))
    @given(messages(cls))
    def round_trip(message: Any) -> None:
        again = cls()
        fill(again, parse(to_yaml(message)))
        assert same(to_plain(again), to_plain(message))
        json.dumps(to_json_plain(to_plain(message)), allow_nan=False)
        assert to_csv(message)

    round_trip()


def test_fields_that_are_not_given_have_their_default():
    message = filled("wide: grüße \U0001f916")
    assert (message.flag, message.text, message.i8) == (True, "default", -8)
    assert (message.octet, message.letter, message.u64) == (b"\x07", 65, 2**64 - 1)
    assert (list(message.pair), list(message.inner.values)) == ([1, 2], [3, 4])
    assert message.wide == "grüße \U0001f916"


def test_constants_are_no_fields():
    assert load_message(KINDS).LIMIT == 7
    with pytest.raises(VerbError, match="has no attribute 'LIMIT'"):
        filled("LIMIT: 8")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("brief: too long", "'brief' takes a string of at most 5 characters"),
        ("wide_brief: too long", "'wide_brief' takes a string of at most 4 characters"),
        ("few: [1, 2, 3, 4, 5]", "'few' takes a list of at most 4 values, got a list of 5"),
        ("few_brief: [a, long]", r"'few_brief\[1\]' takes a string of at most 3 characters"),
        ("three_octets: [1, 2]", "'three_octets' takes a list of 3 values, got a list of 2"),
        ("octets: [256]", r"'octets\[0\]' takes one byte"),
        ("letter: 256", "'letter' takes a whole number from 0 to 255"),
        ("two: [{name: a}]", "'two' takes a list of 2 values"),
        ("two: [{}, {nam: a}]", "'Inner' object has no attribute 'nam'"),
        ("stamp: {sec: 1, nanosec: -1}", "'stamp.nanosec' takes a whole number from 0 to"),
        ("wides: [1, [2]]", r"'wides\[1\]' takes a string"),
    ],
)
def test_what_does_not_fit_is_refused_and_named(text, complaint):
    with pytest.raises(VerbError, match=complaint):
        filled(text)


def test_times_can_be_now():
    message = load_message(KINDS)()
    stamps = fill(message, parse("stamp: now"))
    assert len(stamps) == 1


def test_long_values_are_cut_in_any_kind():
    message = filled("wide: abcdef\nletters: [1, 2, 3]\nwides: [x, y, z]")
    plain = to_plain(message, Style(length=2))
    assert (plain["wide"], plain["wides"]) == ("ab...", ["x", "y", "..."])
    without = to_plain(message, Style(no_arr=True, no_str=True))
    assert without["wide"] == "<string length: <6>>"
    assert without["letters"] == "<sequence type: uint8, length: 3>"


def test_an_action_is_shown_with_what_it_is_made_of():
    assert shown("interface", "show", f"{PACKAGE}/action/Fold") == (
        "# how often\nint32 order\n---\nint32[] sequence\nInner last\n"
        "\twstring name\n\tint32[] values [3, 4]\n---\nwstring progress\n"
    )


def test_constants_and_their_number_signs_are_shown():
    lines = shown("interface", "show", KINDS, "--no-comments").splitlines()
    assert lines[:3] == ["int32 LIMIT=7", 'string GREETING="hello # no comment"', "bool flag true"]
    assert "builtin_interfaces/Duration[<=2] spans" in lines


def test_actions_are_listed_alone_and_with_the_rest():
    assert shown("interface", "list", "-a") == f"Actions:\n    {PACKAGE}/action/Fold\n"
    assert f"    {PACKAGE}/srv/Measure\n" in shown("interface", "list", "-s")
    document = json.loads(shown("interface", "list", "--json"))
    assert f"{PACKAGE}/action/Fold" in document["interfaces"]


@pytest.mark.parametrize(
    ("name", "text"),
    [("action/Fold", "order: 0\n"), ("srv/Measure", "what: ''\n")],
)
def test_prototypes_are_what_a_person_fills_in(name, text):
    assert shown("interface", "proto", f"{PACKAGE}/{name}") == f'"{text}"\n'
    assert shown("interface", "proto", f"{PACKAGE}/{name}", "--no-quotes") == f"{text}\n"


@pytest.mark.parametrize("part", ["FeedbackMessage", "Feedback", "SendGoal_Request", "Goal"])
def test_messages_of_the_topics_and_services_of_an_action_are_found(part):
    message = load_message(f"{PACKAGE}/action/Fold_{part}")()
    assert type(message).__name__ == f"Fold_{part}"


def test_services_of_an_action_are_found():
    kind = load(f"{PACKAGE}/action/Fold_SendGoal", "srv", "not found")
    request = kind.Request()
    fill(request, parse("{goal: {order: 3}}"))
    assert request.goal.order == 3


def test_an_unknown_part_of_an_action_is_refused():
    with pytest.raises(VerbError, match="The passed message type is invalid"):
        load_message(f"{PACKAGE}/action/Fold_Missing")


def test_a_form_has_names_limits_defaults_and_constants_of_every_kind():
    fields = {field["name"]: field for field in form(KINDS)["fields"]}
    rest = {"array": None, "string_most": None, "constants": {}, "fields": None}
    assert fields["flag"] == {"name": "flag", "type": "bool", "default": True, **rest}
    assert fields["text"] == {"name": "text", "type": "string", "default": "default", **rest}
    assert (fields["octet"]["type"], fields["octet"]["default"]) == ("byte", 7)
    assert (fields["u64"]["type"], fields["u64"]["default"]) == ("uint64", 2**64 - 1)
    assert [fields[name]["type"] for name in ("f32", "f64")] == ["float32", "float64"]
    assert fields["i8"]["constants"] == fields["pair"]["constants"] == {"LIMIT": 7}
    assert (fields["brief"]["string_most"], fields["wide_brief"]["type"]) == (5, "wstring")
    shapes = {name: fields[name]["array"] for name in ("pair", "few", "octets")}
    assert shapes == {
        "pair": {"size": 2, "most": None},
        "few": {"size": None, "most": 4},
        "octets": {"size": None, "most": None},
    }
    assert (fields["pair"]["default"], fields["three_octets"]["default"]) == ([1, 2], [0, 0, 0])
    assert (fields["few_brief"]["string_most"], fields["few_brief"]["array"]["most"]) == (3, 2)
    inner = {"name": "", "values": [3, 4]}
    assert (fields["inner"]["default"], fields["two"]["default"]) == (inner, [inner, inner])
    assert (fields["two"]["type"], fields["two"]["array"]["size"]) == (f"{PACKAGE}/msg/Inner", 2)
    assert [field["name"] for field in fields["two"]["fields"]] == ["name", "values"]


def test_the_defaults_of_a_form_are_what_a_new_message_has():
    cls = load_message(KINDS)
    message = cls()
    fill(message, {field["name"]: field["default"] for field in form(KINDS)["fields"]})
    assert same(message, cls())


def test_forms_of_services_actions_and_their_parts():
    service, action = form(f"{PACKAGE}/srv/Measure"), form(f"{PACKAGE}/Fold")
    assert (service["kind"], service["request"][0]["string_most"]) == ("srv", 9)
    assert [field["name"] for field in service["response"]] == ["found"]
    assert (action["type"], action["kind"]) == (f"{PACKAGE}/action/Fold", "action")
    parts = [[field["name"] for field in action[part]] for part in ("goal", "result", "feedback")]
    assert parts == [["order"], ["sequence", "last"], ["progress"]]
    message = form(f"{PACKAGE}/action/Fold_FeedbackMessage")
    assert [field["name"] for field in message["fields"]] == ["goal_id", "feedback"]


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        (f"{PACKAGE}/msg/Kind", f"did you mean '{PACKAGE}/msg/Kinds'?"),
        (f"{PACKAGE}/srv/Measure_Answer", "Measure_Response"),
        ("x", "interface list"),
        ("../msg/A_b", "interface list"),
    ],
)
def test_a_form_of_an_unknown_type_is_refused_with_a_hint(name, hint):
    with pytest.raises(VerbError) as refused:
        form(name)
    assert refused.value.message == f"Unknown interface '{name}'"
    assert hint in str(refused.value.hint)
