"""Quantities, conditions, flags, steps, exit codes and baselines of smoke."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import yaml

from launcher.base.command_line import Command
from launcher.base.document import quantities
from launcher.base.document.fields import FieldType
from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.expect.expectation_kinds import KINDS
from launcher.smoke.expect.message_conditions import Conditions, Expression, fits
from launcher.smoke.observe.facts import Ending, Facts
from launcher.smoke.preflight.loader import parse, parse_entry
from launcher.smoke.reports import measures
from launcher.smoke.reports.measures import Measure
from launcher.smoke.reports.result import Judged, SmokeResult, worst
from launcher.smoke.run.scenario import ChaosTimeline, StepSchedule
from launcher.smoke.smoke_options import EXPECTATIONS
from tests.smoke.unit.cases import expectation_of
from tests.smoke.unit.facts import OVER, lines, running, seen, started
from tests.support.repository import docs_page

# ---- how things are written


@pytest.mark.parametrize(
    ("quantity", "text", "inside", "outside"),
    [
        (quantities.WINDOW, "5 to 8 s", [5, 6.5, 8], [4.9, 8.1]),
        (quantities.WINDOW, "1 .. 2 min", [60, 120], [59, 121]),
        (quantities.WINDOW, 3, [0, 3], [3.1]),
        (quantities.COUNT, "3", [3], [2, 4]),
        (quantities.COUNT, ">= 2", [2, 99], [1]),
        (quantities.COUNT, "< 2", [0, 1], [2]),
        (quantities.COUNT, "2 to 4", [2, 4], [1, 5]),
        (quantities.RATE, "1 Hz ± 20 %", [0.8, 1.2], [0.79, 1.21]),
        (quantities.RATE, "2Hz+-0.5", [1.5, 2.5], [1.4, 2.6]),
        (quantities.RATE, "10 Hz", [9, 11], [8.9, 11.1]),
        (quantities.RATE, ">= 5 Hz", [5, 100], [4.9]),
        (quantities.RATE, "0.9 to 1.1 Hz", [0.9, 1.1], [0.8, 1.2]),
    ],
)
def test_a_range_is_read_with_its_tolerance(
    quantity: FieldType, text: object, inside: list[float], outside: list[float]
):
    span = quantity.parse(text)
    assert all(value in span for value in inside)
    assert not any(value in span for value in outside)


@pytest.mark.parametrize(
    ("quantity", "text", "value"),
    [
        (quantities.DURATION, "500 ms", 0.5),
        (quantities.DURATION, 1.5, 1.5),
        (quantities.DURATION, 1e-7, 1e-7),
        (quantities.SIZE, "200 MB", 200 * 1024**2),
        (quantities.SIZE, "1.5GiB", int(1.5 * 1024**3)),
        (quantities.PERCENT, "80 %", 80),
        (quantities.EXIT, "SIGKILL", -9),
        (quantities.EXIT, 3, 3),
    ],
)
def test_a_value_is_read_with_its_unit(quantity: FieldType, text: object, value: float):
    assert quantity.parse(text) == pytest.approx(value)


@pytest.mark.parametrize("text", ["8 to 5 s", "-1", True, None, [], "1 h"])
def test_a_bad_time_is_reported_with_an_example(text: object):
    with pytest.raises(ValueError, match=r"8 s|ends before"):
        quantities.WINDOW.parse(text)


@pytest.mark.parametrize(
    "text",
    [
        *("m.__class__", "__import__('os')", "open('x')", "().__class__", "x", "m.a =", "1;2"),
        *("f'{m.__class__}'", "'{0.__class__}'.format(m)", "str.format('{0}', m)"),
        *("'{m}'.format_map({})", "lambda _attribute: m", "(" * 300 + ")" * 300, "-" * 10**5),
    ],
)
def test_an_expression_reaches_nothing_but_the_message(text: str):
    with pytest.raises(ValueError, match=r"underscore|unknown name|not a Python|not avail|nested"):
        Expression.parse(text)


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("place == 'dock'", "m.place"),
        ("pose.x > 1", "m.pose"),
        ("m.ok == true", "True"),
        ("m.ok is null", "None"),
    ],
)
def test_a_name_that_the_message_may_have_is_offered_as_a_field(text: str, meant: str):
    with pytest.raises(ValueError, match=rf"did you mean {meant}\? m is the message, and json its"):
        Expression.parse(text)


@pytest.mark.parametrize(
    "text",
    [
        *("m.data.format(m)", "[m.data.format][0](m)", "f'{m.data}'.format_map({'a': m})"),
        *("(x for x in m).gi_frame.f_back.f_globals", "int.mro()", "{1: 2}.items().mapping"),
        *("len.real", "m.data.split.real"),
    ],
)
def test_attributes_are_those_of_fields_and_plain_values(text: str):
    fits, why = Expression.parse(text).holds({"data": "{0.__class__}"})
    assert not fits
    assert why is not None
    assert "is not available here" in why


def test_methods_of_plain_values_are_available():
    text = "sorted(m.data.split(','), key=str.lower) == ['a', 'B'] and m.format == 'jpeg'"
    assert Expression.parse(text).holds({"data": "B,a", "format": "jpeg"}) == (True, None)


def test_json_that_is_nested_too_deeply_is_no_json():
    assert Expression.parse("json is None").holds({"data": "[" * 10**5}) == (True, None)


def test_an_expression_may_have_names_of_its_own():
    found = Expression.parse("sum(x.n for x in m.parts) == 3 and any(k == 'a' for k in json)")
    content = {"parts": [{"n": 1}, {"n": 2}], "data": '{"a": 1}'}
    assert found.holds(content) == (True, None)


def test_fields_may_have_any_names():
    content = {"values": [{"items": 1, "keys": {"get": 2}}]}
    found = Expression.parse("m.values[0].items == 1 and m.values[0].keys == {'get': 2}")
    assert found.holds(content) == (True, None)
    assert Expression.parse("'values' in m and len(m) == 1").holds(content) == (True, None)
    assert Expression.parse("m.items").holds(content)[1] is not None


def test_conditions_look_into_lists_and_into_json():
    found = Conditions.parse({"poses[1].x": {"min": 2}, "robot": {"not": "robot_2"}})
    content: dict[str, Any] = {"poses": [{"x": 1}, {"x": 2.0}], "data": '{"robot": "robot_1"}'}
    assert found.holds(content) == (True, None)
    content["poses"].pop()
    assert found.holds(content) == (False, "unknown field 'poses[1].x'")


# ---- flags

TWO = quantities.COUNT.parse(2)


@pytest.mark.parametrize(
    ("flag", "text", "kind", "values"),
    [
        ("--expect-node", "/a=8s", "node", {}),
        ("--expect-topic", "/a=std_msgs/msg/String", "topic", {"type": "std_msgs/msg/String"}),
        ("--expect-log", "monitor: Fleet report", "log", {"process": "monitor"}),
        ("--expect-log", "robot_[12]: a: b", "log", {"process": "robot_[12]"}),
        ("--expect-log", "nothing else", "log", {}),
        (
            "--expect-log-count",
            "m: a=b=2",
            "log",
            {"process": "m", "count": quantities.COUNT.parse(2)},
        ),
        ("--expect-process", "a", "process", {}),
        ("--expect-process", "a=SIGTERM", "process", {"exits": -15}),
        ("--expect-parameter", "/a:speed=1.5", "parameter", {"node": "/a", "is": 1.5}),
        ("--expect-parameter", "/a:b=[1e-9, .5]", "parameter", {"node": "/a", "is": [1e-9, 0.5]}),
        (
            "--expect-qos-publishers",
            "/a=reliability:reliable",
            "qos",
            {"publishers": {"reliability": "reliable"}},
        ),
        ("--expect-memory", "a=1 MB", "memory", {"below": 1024**2}),
        ("--expect-no-errors", "", "no_errors", {}),
    ],
)
def test_a_flag_is_an_expectation(flag: str, text: str, kind: str, values: dict[str, Any]):
    found = expectation_of(flag, text)
    assert (found.kind, dict(found.values)) == (kind, values)


PAGE = docs_page("smoke")
ROWS = re.findall(r"^\| (`--expect-.*`) \| `(.*)` \|$", PAGE, re.MULTILINE)


@pytest.mark.parametrize(("flags", "entry"), ROWS)
def test_a_flag_is_what_the_page_says(flags: str, entry: str):
    """The entry is that of the first flag of its row."""
    line = shlex.split(flags.split("`")[1])
    (found,) = Command("", "", options=EXPECTATIONS).parse(line).expectations
    wanted = parse_entry(yaml.safe_load(f"{{{entry}}}"), "")
    assert (found.kind, found.subject, found.values) == (
        wanted.kind,
        wanted.subject,
        wanted.values,
    )


def test_every_flag_is_on_the_page():
    assert set(re.findall(r"`(--expect-[a-z-]+)", "".join(flags for flags, _ in ROWS))) == {
        one.flags[0] for one in EXPECTATIONS
    }


@pytest.mark.parametrize("flag", [one.flags[0] for one in EXPECTATIONS])
def test_flags_are_named_like_the_entries_of_a_file(flag: str):
    words = flag.removeprefix("--expect-").replace("-", "_")
    entries = {f"{kind.name}_{field.name}" for kind in KINDS for field in kind.fields}
    assert words in {kind.name for kind in KINDS} | entries


@pytest.mark.parametrize(
    ("flag", "text", "words"),
    [
        ("--expect-rate", "/a", "'/a' is not TOPIC=RATE"),
        ("--expect-rate", "/a=fast", "invalid rate"),
        ("--expect-node", "/a=soon", "invalid time"),
        ("--expect-qos-publishers", "/a=reliabilty:reliable", "reliability"),
        ("--expect-log", "(", "not a regular expression"),
    ],
)
def test_a_mistake_in_a_flag_names_the_flag(flag: str, text: str, words: str):
    with pytest.raises(UsageError) as told:
        expectation_of(flag, text)
    assert flag in told.value.render() and words in told.value.render()


def test_values_to_set_are_those_of_rcl():
    found = parse("scenario: [{do: 'set /n p [1e-9, 0x10]'}, {do: set /n p 1_000}]", "x.yaml")
    assert [step.command.words["value"] for step in found.steps] == [[1e-9, 16], "1_000"]


@pytest.mark.parametrize(
    ("value", "wanted", "is_so"),
    [
        (1e-3, "1e-3", True),
        (1e-3, "1e-2", False),
        ("1e-3", "1e-3", True),
        ([1e-3, 2.0], ["1e-3", 2], True),
        (0.5, {"min": "1e-3", "max": "1e3"}, True),
        (5e3, {"max": "1e3"}, False),
    ],
)
def test_a_number_with_an_exponent_is_one_although_yaml_takes_it_for_a_text(value, wanted, is_so):
    assert fits(value, wanted) is is_so
    assert Conditions.parse({"x": wanted}).holds({"x": value})[0] is is_so


def test_all_mistakes_of_a_file_are_reported_with_line_and_suggestion():
    text = "expect:\n  - nod: /a\n  - {node: /a, withn: 3}\n  - {log: x, after: kil}\n"
    with pytest.raises(LauncherError) as told:
        parse(f"scenario: [{{do: kill a, name: kill}}]\n{text}", "x.yaml")
    rendered = told.value.render()
    for line, near in ((3, "node"), (4, "within"), (5, "kill")):
        assert f"x.yaml:{line}: " in rendered
        assert f"did you mean '{near}'?" in rendered


@pytest.mark.parametrize(
    ("text", "told", "hint"),
    [
        ("expect:\n\t- log: a", "x.yaml:2: ", "not with tabs"),
        ("expect:\n- log: a: b", "x.yaml:2: ", "needs quotes"),
        (
            "scenario:\n- {do: publish /a std_msgs/msg/String {data: x}}",
            "x.yaml:2: ",
            "needs quotes",
        ),
        ("for: 1 s\n---\nfor: 2 s", "expected a single document", ""),
    ],
)
def test_invalid_yaml_is_reported_with_the_usual_cause(text: str, told: str, hint: str):
    with pytest.raises(LauncherError) as raised:
        parse(text, "x.yaml")
    assert told in raised.value.render() and hint in (raised.value.hint or "")


# ---- what happens when


def test_steps_run_once_their_condition_holds():
    script = parse(
        """
        scenario:
          - {at: 2 s, do: kill a, name: kill}
          - {at: 1 s, after: kill, do: start a, name: again}
          - {after_log: hello, at: 1 s, do: stop b, name: polite}
        """,
        "x.yaml",
    )
    timeline = StepSchedule(script.steps)

    def due(now_s: float, **facts: Any) -> list[str]:
        return [step.name for step in timeline.due(running(now_s, **facts))]

    assert due(1.9) == []
    assert due(2.0) == ["kill"]
    assert due(9.0, steps={"kill": 2.0}) == []
    assert due(9.0, steps={"kill: done": 8.5}, lines=lines("hello", at_s=8.5)) == []
    assert due(9.5, steps={"kill: done": 8.5}, lines=lines("hello", at_s=8.5)) == [
        "again",
        "polite",
    ]
    assert timeline.waiting == ()


def test_the_time_of_a_run_follows_from_its_expectations():
    script = parse(
        """
        scenario: [{at: 8 s, do: pause a for 2 s, name: nap}]
        expect: [{log: x, after: 'nap: over', within: 5 to 8 s}, {node: /a, within: 3 s}]
        """,
        "x.yaml",
    )
    assert script.run_time_s() == 18.0
    assert script.ready_limit_s() == 3.0


@pytest.mark.parametrize("seed", [1, 7])
def test_chaos_chooses_by_its_seed_alone(seed: int):
    script = parse(f"{{chaos: kill one of robot_* every 2 s, seed: {seed}}}", "x.yaml")
    facts = running(9.0, steps={"ready": 1.0}, events=started("robot_1-1", "robot_2-2", "x-3"))
    assert script.chaos is not None
    once, again = ([s.process for s in ChaosTimeline(script.chaos).due(facts)] for _ in range(2))
    assert once == again and len(once) == 4
    assert set(once) <= {"robot_1-1", "robot_2-2"}


# ---- what it comes to


def judged(outcome: Decision = Decision.MET, *, implicit: bool = False, **values: Any) -> Judged:
    expectation = Expectation(kind="rate", subject="/a", name="rate /a", implicit=implicit)
    return Judged(expectation=expectation, verdict=Verdict(outcome=outcome, expected="", **values))


def result(*found: Judged, facts: Facts | None = None, **more: Any) -> SmokeResult:
    facts = facts or seen()
    return SmokeResult(judged=found, facts=facts, folder=Path(), words=(), domain_id=1, **more)


BAD, IMPLICIT = judged(Decision.VIOLATED), judged(Decision.VIOLATED, implicit=True)
NOTHING = Ending(asked_s=None, down_s=1, returncode=2)


@pytest.mark.parametrize(
    ("found", "code"),
    [
        (result(judged()), ExitCode.OK),
        (result(IMPLICIT), ExitCode.PROCESS_FAILED),
        (result(judged(), trouble="left behind"), ExitCode.PROCESS_FAILED),
        (result(BAD, IMPLICIT), ExitCode.NOT_MET),
        (result(BAD, gave_up=True), ExitCode.NOT_READY),
        (result(BAD, interrupted=ExitCode.TERMINATED), ExitCode.TERMINATED),
        (result(BAD, facts=seen(events=(), ending=NOTHING)), ExitCode.USAGE),
        (result(BAD, facts=seen(ending=OVER)), ExitCode.NOT_MET),
    ],
)
def test_the_exit_code_is_that_of_the_worst_result(found: SmokeResult, code: ExitCode):
    assert found.exit_code is code


def test_of_several_runs_the_worst_counts():
    codes = [ExitCode.OK, ExitCode.PROCESS_FAILED, ExitCode.NOT_READY, ExitCode.NOT_MET]
    assert worst(codes) is ExitCode.NOT_READY
    assert worst([ExitCode.OK]) is ExitCode.OK


@pytest.mark.parametrize(
    ("kind", "base", "good", "bad"),
    [
        ("rate", 10.0, [8.1, 11.9], [7.9, 12.1]),
        ("start_up", 1.0, [0.1, 1.9], [2.1]),
        ("start_up", 10.0, [1.0, 14.9], [15.1]),
        ("cpu", 2.0, [0.0, 11.9], [12.1]),
        ("memory", 100.0, [10.0, 124.0], [126.0]),
    ],
)
def test_a_measure_may_be_worse_by_its_tolerance(
    tmp_path: Path, kind: str, base: float, good: list[float], bad: list[float]
):
    path = tmp_path / "baseline.json"
    measures.write(path, [Measure(name="it", kind=kind, value=base, unit="u")])

    def outcome(value: float) -> Decision:
        now = Measure(name="it", kind=kind, value=value, unit="u")
        (found,) = measures.compare(path, [now])
        return found.verdict.outcome

    assert [outcome(value) for value in good] == [Decision.MET] * len(good)
    assert [outcome(value) for value in bad] == [Decision.VIOLATED] * len(bad)


def test_a_measure_that_is_missing_is_worse_and_tolerances_may_be_changed(tmp_path: Path):
    path = tmp_path / "baseline.json"
    now = Measure(name="it", kind="cpu", value=30.0, unit="%")
    measures.write(path, [Measure(name="it", kind="cpu", value=10.0, unit="%")])
    assert measures.compare(path, [])[0].verdict.outcome is Decision.VIOLATED
    assert measures.compare(path, [now])[0].verdict.outcome is Decision.VIOLATED
    document = json.loads(path.read_text("utf-8"))
    document["tolerances"]["cpu"]["percent"] = 300
    path.write_text(json.dumps(document), encoding="utf-8")
    assert measures.compare(path, [now])[0].verdict.outcome is Decision.MET


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"measures": {"a": 1}}', '{"measures": 1}'])
def test_a_file_that_is_not_a_baseline_is_reported(tmp_path: Path, text: str):
    path = tmp_path / "baseline.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UsageError, match="not a baseline"):
        measures.compare(path, [])


def test_measures_of_several_runs_are_their_medians():
    runs = [[Measure(name="a", kind="cpu", value=value, unit="%")] for value in (1.0, 9.0, 2.0)]
    assert [m.value for m in measures.medians(runs)] == [2.0]
