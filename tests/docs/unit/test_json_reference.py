"""The page of what `--json` prints, and that no verb prints JSON in another way."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.base.option import JSON, JSON_LINES, Option
from tests.support.json_forms import VERBS
from tests.support.repository import REPOSITORY
from tools import json_reference
from tools.command_reference import commands
from tools.json_forms import all_forms, form_of
from tools.json_keys import Key, faults_of, keys_in

SNAKE_CASE = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
TEXTS = [text for form in all_forms() for text in form.kinds]


def test_the_page_is_generated_from_the_table():
    assert json_reference.PAGE.read_text(encoding="utf-8") == json_reference.page()


def json_options() -> dict[str, Option]:
    """The option of each verb that has one."""
    return {
        command.name: one
        for command in commands()
        for one in command.all_options
        if "--json" in one.flags
    }


def test_the_table_has_every_verb_with_such_an_option_once():
    assert len(VERBS) == len(set(VERBS))
    assert {verb.partition(" --")[0] for verb in VERBS} == json_options().keys()


def test_the_option_says_whether_a_verb_prints_lines():
    for verb, option in json_options().items():
        expected = JSON_LINES if form_of(verb).lines else JSON
        assert re.split("[;,]", option.help)[0] == expected.help, verb


def names_in(keys: tuple[Key, ...]) -> Iterator[str]:
    for key in keys:
        yield key.name
        yield from names_in(key.inner)


def test_keys_are_in_snake_case_and_version_is_none_of_them():
    names = {name for text in TEXTS for name in names_in(keys_in(text))}
    assert {name for name in names if not SNAKE_CASE.fullmatch(name)} == set()
    assert "version" not in names  # it is added to every answer


@pytest.mark.parametrize(
    ("answer", "faults"),
    [
        ({"a": 1, "c": {"x": None}, "d": [{"e": "", "f": []}], "g": {"any": [{}]}}, []),
        ({"a": None, "b": True, "c": None, "d": []}, ["missing .g"]),
        ({"a": [], "c": {"y": 1}, "d": {}, "g": 1}, [".a is list", ".c.y", ".c.x", ".d is dict"]),
        ({"a": 1, "c": None, "d": [1, {"e": 1, "f": [[]]}], "g": 1, "h": 1}, [".h", "[0]", "f[0]"]),
        ([], ["the answer is no object"]),
    ],
)
def test_answers_are_compared_with_a_form(answer: object, faults: list[str]):
    found = list(faults_of(answer, keys_in("a, b?, c{x}, d[e, f[]], g*")))
    assert len(found) == len(faults), found


def test_a_text_that_is_no_form_is_refused():
    for text in ("a, b[c", "a]", "a, {b}"):
        with pytest.raises(ValueError):
            keys_in(text)


# ---- one way to print


def printed_json(path: Path) -> Iterator[str]:
    """Calls that print JSON for other programs, but JSON Schemas."""
    text = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)) if "dumps(" in text else ():
        if isinstance(node, ast.Call) and called(node) in ("print", "print_text", "write"):
            inner = {called(one) for one in ast.walk(node) if isinstance(one, ast.Call)}
            if "dumps" in inner and "json_schema" not in inner:
                yield f"{path.relative_to(REPOSITORY)}:{node.lineno}"


def called(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def test_only_one_module_prints_answers():
    found = [one for path in (REPOSITORY / "launcher").rglob("*.py") for one in printed_json(path)]
    files = {one.partition(":")[0] for one in found}
    # These write files: tables of messages, and the plan of a run.
    assert files == {
        "launcher/bag/converting/text_tables.py",
        "launcher/output/logs/run_directory.py",
    }


# Verbs that need more than the tests below have: `ControlledRun.ask` compares every answer.
ELSEWHERE = {
    "debug": "control/process/test_debug.py",
    "loglevel": "run/process/test_log_levels.py",
    "faults": "faults/process/test_faults_verb.py",
    "faults --all-runs": "faults/unit/test_history.py",
    "faults --follow": "faults/process/test_faults_verb.py",
    "inject": "smoke/process/test_inject.py",
    "snapshot": "bag/ros/test_flight_recorder.py",
    "doctor --report": "doctor/ros/test_report.py",
    "doctor --uninstall-list": "doctor/process/test_remains.py",
    "detach": "hosts/lab/test_attach.py",
    "foxglove": "ros/ros/foxglove/test_server.py",
    "incident": "faults/unit/test_incident_verb.py",
    **dict.fromkeys(("tf tree", "tf echo"), "bag/unit/test_transforms.py"),
    "tf monitor": "ros/ros/test_tf.py",
    "wait": "ros/process/test_wait.py",
}


def test_the_form_of_every_verb_is_compared_with_real_answers():
    folder = REPOSITORY / "tests"
    texts = [path.read_text(encoding="utf-8") for path in folder.rglob("test_json_forms.py")]
    names = [*ELSEWHERE, *(verb for verb in VERBS if any(f'"{verb}"' in text for text in texts))]
    assert sorted(names) == sorted(VERBS)
    for verb, file in ELSEWHERE.items():
        assert f'"{verb}"' in (folder / file).read_text(encoding="utf-8")
