"""Plans of injections: reading with all mistakes, and the same choices for the same seed."""

from __future__ import annotations

import itertools
import json

import jsonschema
import pytest
import yaml

from launcher.base.errors import LauncherError, SeveralErrors
from launcher.smoke.inject.chaos_plan import json_schema, parse
from tests.support.repository import REPOSITORY, docs_page

PLAN = """
seed: 7
every: 5 to 20 s
injections:
  - {inject: "robot_* slow 4", for: 1 to 3 s, weight: 2}
  - {inject: monitor kill}
  - {inject: machine cpu 1 for 2 s}
"""
VALIDATOR = jsonschema.Draft202012Validator(json_schema())


def test_a_seed_gives_the_same_plan():
    first, second = (list(itertools.islice(parse(PLAN, "a").steps(), 300)) for _ in range(2))
    assert first == second
    assert first != list(itertools.islice(parse(PLAN.replace("7", "8"), "a").steps(), 300))
    times = [one.at_s for one in first]
    assert all(5 <= after - at <= 20 for at, after in itertools.pairwise([0.0, *times]))
    kinds = [one.injection.kind for one in first]
    assert kinds.count("slow") > kinds.count("kill") > 30
    slow = [one for one in first if one.injection.kind == "slow"]
    assert all(1 <= (one.injection.for_s or 0) <= 3 for one in slow)
    assert {one.target(["a", "b", "c"]) for one in slow} == {"a", "b", "c"}
    assert {one.injection.for_s for one in first if one.name == "machine"} == {2.0}


def test_a_plan_may_have_an_end_and_equal_steps():
    text = "{every: 10 s, start: 3 s, for: 35 s, injections: [{inject: a pause}]}"
    plan = parse(text, "a")
    assert [one.at_s for one in plan.steps()] == [10.0, 20.0, 30.0]
    assert plan.start_s == 3.0


def test_all_mistakes_are_reported_with_their_lines():
    text = """\
seed: x
evry: 10 s
injections:
  - {inject: robot_1 slwo 4}
  - {inject: robot_1 kill, for: 3 s}
  - {inject: robot_1 pause, weight: 0}
  - {wait: 1}
"""
    with pytest.raises(SeveralErrors) as found:
        parse(text, "plan.yaml")
    said = [(one.where or "", one.message) for one in found.value.errors]
    for line, part in (
        (1, "'x' is not an integer"),
        (2, "unknown key 'evry'"),
        (4, "unknown injection 'slwo'"),
        (5, "kill takes no time"),
        (6, "is not a number above 0"),
        (7, "an injection has no 'wait'"),
        (7, "an injection needs 'inject'"),
    ):
        assert any(where == f"plan.yaml:{line}" and part in text for where, text in said), said


@pytest.mark.parametrize("text", ["", "[]", "every: 0 s\ninjections: [{inject: a pause}]"])
def test_what_is_no_plan_is_refused(text: str):
    with pytest.raises(LauncherError):
        parse(text, "a")


def test_the_schema_is_that_of_the_reader_and_fits_the_example():
    path = REPOSITORY / "launcher/faults/chaos.schema.json"
    assert json.loads(path.read_text(encoding="utf-8")) == json_schema()
    jsonschema.Draft202012Validator.check_schema(json_schema())
    example = docs_page("inject").split("```yaml\n")[1].split("```")[0]
    assert len(parse(example, "inject.md").entries) == 3
    for text in (PLAN, example):
        VALIDATOR.validate(yaml.safe_load(text))
    assert not VALIDATOR.is_valid({"every": "1 s", "injections": [{"inject": "a slwo"}]})
