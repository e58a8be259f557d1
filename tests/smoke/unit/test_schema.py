"""The loader, the JSON schema and docs/reference/smoke.md agree about expectation files."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from launcher.base.errors import LauncherError
from launcher.smoke.expect.expectation_entries import json_schema
from launcher.smoke.expect.expectation_kinds import KINDS
from launcher.smoke.preflight import loader
from tests.support.repository import REPOSITORY, docs_page

SCHEMA = json_schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)

GOOD = {
    "nothing": "",
    "no expectation": "expect: []",
    "node": "expect: [{node: /robot_1, within: 8 s}]",
    "nodes anywhere": "expect: [{node: '*/robot_1'}]",
    "node pattern": "expect: [{node: /robot_*, absent: true}]",
    "topic": "expect: [{topic: /a, type: a/msg/B, publishers: 1, subscriptions: '>= 2'}]",
    "qos": "expect: [{qos: /a, publishers: {reliability: best_effort, deadline: 2 s}}]",
    "qos pairs": "expect: [{qos: /a, compatible: false, node: /robot_*}]",
    "rate in words": "expect: [{rate: /a, is: 1 Hz ± 20 %}]",
    "rate in ascii": "expect: [{rate: /a, is: 1Hz+-20%}]",
    "rate as number": "expect: [{rate: /a, is: 2.5}]",
    "rate from to": "expect: [{rate: /a, is: 0.9 to 1.1 Hz}]",
    "rate at least": "expect: [{rate: /a, is: '>= 5 Hz', where: 'm.data'}]",
    "gap": "expect: [{gap: /a, below: 2 s, type: a/msg/B, fields: {x: 1}}]",
    "latency": "expect: [{latency: /a, below: 50 ms, where: m.x}]",
    "message": "expect: [{message: /a, where: \"json.status == 'done'\", count: 2 to 4}]",
    "message fields": "expect: [{message: /a, fields: {x: 1, y: [1, 2], z: {min: 0}}}]",
    "all messages": "expect: [{message: /a, all: true, where: 'len(m.data) < 9'}]",
    "message with qos": "expect: [{message: /a, qos: {reliability: reliable, depth: 3}}]",
    "unique": "expect: [{unique: /a, key: task_id, where: m.data}]",
    "unique pairs": "expect: [{unique: /a, key: [robot_id, 'poses[0].x']}]",
    "refers": "expect: [{refers: /a, to: /b, key: task_id, fields: {status: done}}]",
    "tally": "expect: [{tally: /a, in: /b, number: 'n: (.*)', key: task_id, lag: 2 s}]",
    "log": "expect: [{log: 'Fleet report', process: monitor, level: WARN, within: 5 to 8 s}]",
    "no log": "expect: [{log: dropped, count: 0}]",
    "order": "expect: [{order: [first, second], process: monitor}]",
    "no errors": "expect: [{no_errors: '*', except: [harmless]}]",
    "no tracebacks": "expect: [{no_tracebacks: robot_*}]",
    "alive": "expect: [{process: robot_1}]",
    "exit": "expect: [{process: robot_1, exits: 3, within: 2}]",
    "exit by signal": "expect: [{process: robot_1, exits: SIGKILL}]",
    "restarts": "expect: [{process: robot_1, restarts: '>= 1', alive: true}]",
    "cpu": "expect: [{cpu: robot_*, below: 50 %, peak: 90}]",
    "memory": "expect: [{memory: robot_*, below: 200 MB}]",
    "growth": "expect: [{memory: robot_1, growth: 1 MB/min}, {memory: a, growth: 0.5KiB/s}]",
    "node once": "expect: [{node: /a, count: 1}]",
    "parameter": "expect: [{parameter: a, node: /b, is: [1, 2]}]",
    "service": "expect: [{service: /a, request: {data: true}, fields: {success: true}}]",
    "service once": "expect: [{service: /a, once: true, where: m.success}]",
    "run": "expect: [{start_up: 5 s}, {clean_shutdown: 3 s}, {shared_memory: clean}]",
    "ready": "expect: [{ready: 'robot_*', within: 5 s}]",
    "like": "expect: [{like: good.mcap, name: as ever}]",
    "like in parts": "expect: [{like: {bag: a, rates: 9 %, gaps: 5, topics: [/a], exclude: [/b]}}]",
    "confirmed by time": "expect: [{node: /a, confirm: 2 s, heal: 500 ms}]",
    "confirmed by number": "expect: [{rate: /a, is: 1 Hz, confirm: 3 times, heal: 5}]",
    "deaths": "expect: [{no_deaths: '*'}]",
    "scenario": "scenario: [{at: 8 s, do: kill a, name: kill}, {after: kill, do: start a}]",
    "pause": "scenario: [{do: pause robot_1 for 500 ms}]",
    "publish": "scenario: [{do: 'publish /a std_msgs/msg/String {data: x}'}]",
    "set": "scenario: [{do: set parameter /a speed 1.5}, {do: set /a name x}]",
    "call": "scenario: [{do: call service /a std_srvs/srv/Trigger}]",
    "after a line": "scenario: [{after_log: ready, process: a, at: 1 s, do: stop a}]",
    "chaos": "{chaos: kill one of robot_* every 5 s, seed: 7}",
    "pausing chaos": "{chaos: pause one of robot_* every 5 s for 2 s}",
    "top": "{for: 20 s, ready_within: 10, arguments: {a: true, b: 1}, options: [--lenient]}",
}
BAD = {
    "a list": "[1, 2]",
    "unknown entry": "expects: []",
    "relative node": "expect: [{node: robot_1}]",
    "unknown kind": "expect: [{nod: /a}]",
    "no mapping": "expect: [node]",
    "expectations as mapping": "expect: {node: /a}",
    "two kinds": "expect: [{node: /a, log: b}]",
    "unknown field": "expect: [{node: /a, withn: 8 s}]",
    "no time": "expect: [{node: /a, within: soon}]",
    "negative time": "expect: [{node: /a, within: -1}]",
    "relative topic": "expect: [{topic: fleet/tasks}]",
    "no count": "expect: [{topic: /a, publishers: some}]",
    "half a count": "expect: [{topic: /a, publishers: 1.5}]",
    "nothing of qos": "expect: [{qos: /a}]",
    "unknown policy": "expect: [{qos: /a, publishers: {reliabilty: reliable}}]",
    "unknown reliability": "expect: [{qos: /a, publishers: {reliability: good}}]",
    "no key": "expect: [{unique: /a}]",
    "a bad key": "expect: [{unique: /a, key: []}]",
    "no other topic": "expect: [{refers: /a, key: b}]",
    "no number": "expect: [{tally: /a, in: /b, key: c}]",
    "no rate": "expect: [{rate: /a}]",
    "a bad rate": "expect: [{rate: /a, is: fast}]",
    "a bad limit": "expect: [{message: /a, fields: {x: {least: 1}}}]",
    "limit of true": "expect: [{message: /a, fields: {x: {min: true}}}]",
    "no fields": "expect: [{message: /a, fields: {}}]",
    "unknown level": "expect: [{log: a, level: LOUD}]",
    "no regex": "expect: [{log: 3}]",
    "one is no order": "expect: [{order: [a]}]",
    "no flag": "expect: [{process: a, alive: maybe}]",
    "no exit code": "expect: [{process: a, exits: badly}]",
    "negative exit code": "expect: [{process: a, exits: -9}]",
    "no cpu": "expect: [{cpu: a}]",
    "no memory": "expect: [{memory: a, below: much}]",
    "nothing of memory": "expect: [{memory: a}]",
    "growth without a period": "expect: [{memory: a, growth: 1 MB}]",
    "growth as number": "expect: [{memory: a, growth: 3}]",
    "no gap": "expect: [{gap: /a}]",
    "no latency": "expect: [{latency: /a, below: soon}]",
    "no parameter": "expect: [{parameter: a, node: /b}]",
    "no request": "expect: [{service: /a, request: yes please}]",
    "like nothing": "expect: [{like: ''}]",
    "like no bag": "expect: [{like: {rates: 20 %}}]",
    "like a number": "expect: [{like: 3}]",
    "like without numbers": "expect: [{like: {bag: a, rates: fast}}]",
    "like relative topics": "expect: [{like: {bag: a, topics: [b]}}]",
    "like one topic": "expect: [{like: {bag: a, topics: /b}}]",
    "like misspelt": "expect: [{like: {bag: a, rate: 20 %}}]",
    "a timed likeness": "expect: [{like: a, within: 3 s}]",
    "timed start": "expect: [{start_up: 5 s, within: 3 s}]",
    "never confirmed": "expect: [{node: /a, confirm: 0 times}]",
    "no confirmation": "expect: [{node: /a, confirm: often}]",
    "healed at the end": "expect: [{start_up: 5 s, heal: 3 s}]",
    "dirty": "expect: [{shared_memory: dirty}]",
    "no step": "scenario: [kill robot_2]",
    "nothing to do": "scenario: [{at: 3 s}]",
    "unknown command": "scenario: [{do: kil robot_2}]",
    "half a command": "scenario: [{do: publish /a}]",
    "no chaos": "chaos: kill everything",
    "no seed": "seed: x",
    "no arguments": "arguments: [a]",
    "nested arguments": "arguments: {a: [1]}",
    "no options": "options: --lenient",
}


def is_loaded(text: str) -> bool:
    try:
        loader.parse(text, "x.yaml")
    except LauncherError:
        return False
    return True


def fits_schema(text: str) -> bool:
    return bool(VALIDATOR.is_valid(yaml.safe_load(text)))


@pytest.mark.parametrize("text", GOOD.values(), ids=GOOD)
def test_a_good_file_is_good_for_the_loader_and_the_schema(text: str):
    loader.parse(text, "x.yaml")
    VALIDATOR.validate(yaml.safe_load(text))


@pytest.mark.parametrize("text", BAD.values(), ids=BAD)
def test_a_bad_file_is_bad_for_the_loader_and_the_schema(text: str):
    assert (is_loaded(text), fits_schema(text)) == (False, False)


@pytest.mark.parametrize(
    ("text", "for_s", "times"), [("2 s", 2.0, None), ("0.5", 0.5, None), ("3 times", None, 3)]
)
def test_a_violation_is_confirmed_by_time_or_by_number(text, for_s, times):
    script = loader.parse(f"expect: [{{node: /a, confirm: {text}, heal: 1 min}}]", "x.yaml")
    (expectation,) = script.expectations
    confirm = expectation.get("confirm")
    assert (confirm.for_s, confirm.times, confirm.text) == (for_s, times, text)
    assert expectation.get("heal") == 60.0


def test_every_kind_is_in_the_sample_files():
    found = {
        key
        for text in GOOD.values()
        for entry in (yaml.safe_load(text) or {}).get("expect") or ()
        for key in entry
    }
    assert {kind.name for kind in KINDS} <= found


def test_the_patterns_of_the_schema_are_those_of_editors_too():
    assert "(?P<" not in str(SCHEMA)  # Python's own, which ECMAScript refuses
    assert "(?:" in str(SCHEMA)


def test_the_schema_in_the_repository_is_the_one_of_the_loader():
    path = REPOSITORY / "launcher" / "smoke" / "expectations.schema.json"
    assert json.loads(path.read_text(encoding="utf-8")) == SCHEMA
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


def test_the_documentation_has_a_row_for_each_kind_with_all_its_entries():
    document = docs_page("smoke")
    for kind in KINDS:
        row = next(line for line in document.splitlines() if line.startswith(f"| `{kind.name}` |"))
        assert kind.doc in row
        assert all(f"`{field.name}`" in row for field in kind.fields), kind.name


def test_the_example_of_the_documentation_is_a_good_file():
    document = docs_page("smoke")
    example = document.split("```yaml\n")[1].split("```")[0]
    script = loader.parse(example, "smoke.md")
    assert len(script.expectations) == 4
    assert fits_schema(example)


@pytest.mark.parametrize("name", ["system.expect.yaml", "system.expect.yml"])
def test_the_file_beside_a_launch_file_is_found_however_yaml_is_spelt(tmp_path: Path, name: str):
    (tmp_path / name).write_text("", encoding="utf-8")
    for launch_file in ("system.launch.py", "system_launch.xml", "system.py"):
        assert loader.beside(str(tmp_path / launch_file)) == tmp_path / name
    assert loader.beside(str(tmp_path / "other.launch.py")) is None


@pytest.mark.parametrize(
    ("entry", "hint"),
    [("no_errors", "as in '- no_errors: ...'"), ("[1]", "as in '- node: /robot_1'")],
)
def test_an_expectation_that_is_not_a_mapping_gets_a_hint(entry: str, hint: str):
    with pytest.raises(LauncherError) as told:
        loader.parse(f"expect: [{entry}]", "x.yaml")
    assert told.value.hint == hint


# ---- misspelt keys

VALUES: dict[str, Any] = {
    "type": "std_msgs/msg/String",
    "process": "p",
    "node": "/n",
    "level": "WARN",
    "publishers": 1,
    "subscriptions": 1,
    "count": 1,
    "restarts": 1,
    "exits": 0,
    "is": "1 Hz",
    "below": "80",
    "peak": "80",
    "growth": "1 MB/min",
    "where": "m",
    "fields": {"a": 1},
    "request": {"a": 1},
    "key": "a",
    "to": "/b",
    "in": "/b",
    "number": "(1)",
    "lag": "1 s",
    "qos": {"depth": 3},
    "except": ["x"],
    "name": "n",
    "within": "3 s",
    "after": "start",
    "confirm": "3 times",
    "heal": "5 s",
    **dict.fromkeys(("absent", "compatible", "all", "alive", "once", "call"), True),
}
SUBJECTS: dict[str, Any] = {
    **dict.fromkeys(("node", "topic", "qos", "rate", "message", "service"), "/a"),
    **dict.fromkeys(("gap", "latency"), "/a"),
    **dict.fromkeys(("unique", "refers", "tally"), "/a"),
    **dict.fromkeys(("start_up", "clean_shutdown"), "3 s"),
    "order": ["a", "b"],
    "shared_memory": "clean",
    "ready": "robot_1",
    "no_deaths": "*",
}


def typos(key: str) -> set[str]:
    """A letter is missing, or two are exchanged; short words are similar to too many."""
    return (
        {key[:-1], key[0] + key[2:], key[0] + key[2] + key[1] + key[3:]} if len(key) > 3 else set()
    )


def whole_entries() -> Iterator[tuple[str, dict[str, Any]]]:
    """An entry of each kind with all that it may have."""
    for kind in KINDS:
        entry = {field.name: VALUES[field.name] for field in kind.all_fields()}
        if kind.name == "qos":
            entry["publishers"] = entry["subscriptions"] = {"reliability": "reliable"}
        yield kind.name, {kind.name: SUBJECTS.get(kind.name, "p"), **entry}


@pytest.mark.parametrize(("kind", "entry"), [*whole_entries()])
def test_every_misspelt_key_of_an_expectation_is_told_once_with_the_right_one(
    kind: str, entry: dict[str, Any]
):
    loader.parse(yaml.safe_dump({"expect": [entry]}), "x.yaml")
    for key in entry:
        for typo in typos(key) - entry.keys():
            misspelt = {(typo if name == key else name): one for name, one in entry.items()}
            with pytest.raises(LauncherError) as told:
                loader.parse(yaml.safe_dump({"expect": [misspelt]}, sort_keys=False), "x.yaml")
            rendered = told.value.render()
            assert f"'{typo}'" in rendered and f"did you mean '{key}'?" in rendered, rendered
            assert rendered.count("x.yaml:") == 1, rendered


@pytest.mark.parametrize(
    ("text", "said", "hint"),
    [
        ("expect: [{parametr: speed, node: /n, is: 1}]", "'parametr'", "did you mean 'parameter'?"),
        ("expect: [{node: /n, is: 1, parametr: a}]", "'parametr'", "did you mean 'parameter'?"),
        ("expect: [{lgo: x, process: p}]", "'lgo'", "did you mean 'log'?"),
        ("expect: [{within: 3 s, nod: /a}]", "'nod'", "did you mean 'node'?"),
        ("expect: [{cpu: p, blow: 3}]", "'blow' of 'cpu'", "did you mean 'below'?"),
        ("expect: [{rate: /a, si: 1 Hz}]", "'si' of 'rate'", "did you mean 'is'?"),
        ("expect: [{within: 3 s}]", "an expectation without its kind", "it needs one of node,"),
        ("expect: [{message: /a, fields: {x: {mni: 3}}}]", "'mni' of 'x'", "did you mean 'min'?"),
        (
            "expect: [{qos: /a, publishers: {durabilty: volatile}}]",
            "",
            "did you mean 'durability'?",
        ),
        ("expect: [{service: /a, call: false, where: m}]", "'where' needs a call", ""),
        ("scenario: [{doo: kill a}]", "'doo' of a step", "did you mean 'do'?"),
        ("redy_within: 3 s", "'redy_within'", "did you mean 'ready_within'?"),
        ("expct: []", "'expct'", "did you mean 'expect'?"),
    ],
)
def test_a_misspelt_key_is_told_with_the_near_one(text: str, said: str, hint: str):
    with pytest.raises(LauncherError) as told:
        loader.parse(text, "x.yaml")
    rendered = told.value.render()
    assert said in rendered and hint in rendered, rendered
    assert rendered.count("x.yaml:") == 1, rendered
