"""Encoding and decoding of payloads; bad ones are refused."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from group_gp1.logic.messages import (
    MAX_PAYLOAD_CHARS,
    MAX_SHOWN_CHARS,
    RECENTLY_COMPLETED,
    MessageError,
    RobotStatus,
    Status,
    TaskAssignment,
    one_line,
    report_text,
)

PRINTABLE = st.characters(exclude_categories=("C", "Z"), include_characters=" ")
NAMES = st.text(PRINTABLE, min_size=1, max_size=40)
ASSIGNMENTS = st.builds(
    TaskAssignment, robot_id=NAMES, task=NAMES, task_id=st.one_of(st.none(), NAMES)
)
STATUSES = st.builds(
    RobotStatus,
    robot_id=NAMES,
    status=st.sampled_from(Status),
    task=NAMES,
    task_id=st.one_of(st.none(), NAMES),
    completed=st.one_of(
        st.none(), st.lists(NAMES, max_size=RECENTLY_COMPLETED).map(lambda ids: tuple(ids))
    ),
)
STATUS = {"robot_id": "robot_1", "status": "done", "task": "t"}


@given(ASSIGNMENTS)
def test_an_assignment_survives_encoding_and_decoding(assignment):
    assert TaskAssignment.from_json(assignment.to_json()) == assignment


@given(STATUSES.filter(lambda status: len(status.to_json()) <= MAX_PAYLOAD_CHARS))
def test_a_status_survives_encoding_and_decoding(status):
    assert RobotStatus.from_json(status.to_json()) == status


@given(st.one_of(st.text(), st.recursive(st.none() | st.floats() | st.text(), st.lists)))
def test_any_payload_is_read_or_refused_as_a_message_error(value):
    payload = value if isinstance(value, str) else json.dumps(value)
    with pytest.raises(MessageError):
        RobotStatus.from_json(payload)


def test_the_named_fields_are_those_of_the_scenario():
    status = RobotStatus(robot_id="robot_2", status=Status.BUSY, task="deliver_dock_2")
    assignment = TaskAssignment(robot_id="robot_2", task="deliver_dock_2")

    assert json.loads(assignment.to_json()) == {"robot_id": "robot_2", "task": "deliver_dock_2"}
    assert json.loads(status.to_json()) == {
        "robot_id": "robot_2",
        "status": "busy",
        "task": "deliver_dock_2",
    }


def test_unknown_fields_are_ignored():
    payload = json.dumps({"robot_id": "robot_1", "task": "t", "colour": [1, 2]})

    assert TaskAssignment.from_json(payload) == TaskAssignment(robot_id="robot_1", task="t")


def test_an_idle_robot_may_have_no_task():
    status = RobotStatus.from_json(json.dumps({**STATUS, "task": ""}))

    assert (status.status, status.task) == (Status.DONE, "")


REFUSED = {
    "no JSON": ("{", "not JSON"),
    "deep": ("[" * 4000, "not JSON"),
    "null": ("null", "not a JSON object but null"),
    "array": ("[1]", "not a JSON object but an array"),
    "number": ("7", "not a JSON object but a number"),
    "huge": ("x" * (MAX_PAYLOAD_CHARS + 1), f"more than {MAX_PAYLOAD_CHARS}"),
    "missing": ('{"robot_id": "a", "status": "done"}', "field 'task' is missing"),
    "null field": (json.dumps({**STATUS, "task": None}), "'task' must be a string, not null"),
    "bool field": (json.dumps({**STATUS, "task": True}), "must be a string, not a boolean"),
    "object field": (json.dumps({**STATUS, "robot_id": {}}), "must be a string, not an object"),
    "empty name": (json.dumps({**STATUS, "robot_id": ""}), "field 'robot_id' is empty"),
    "busy with nothing": (json.dumps({**STATUS, "status": "busy", "task": ""}), "is empty"),
    "long name": (json.dumps({**STATUS, "task": "a" * 129}), "longer than 128 characters"),
    "line break": (json.dumps({**STATUS, "task": "a\nb"}), "cannot be printed"),
    "status": (json.dumps({**STATUS, "status": "gone"}), "must be busy or done, not 'gone'"),
    "task id": (json.dumps({**STATUS, "task_id": 5}), "field 'task_id' must be a string"),
    "completed": (json.dumps({**STATUS, "completed": "a"}), "must be an array of strings"),
    "completed of": (json.dumps({**STATUS, "completed": [1]}), "must be an array of strings"),
    "many completed": (json.dumps({**STATUS, "completed": ["a"] * 11}), "more than 10 entries"),
}


@pytest.mark.parametrize(("payload", "reason"), REFUSED.values(), ids=REFUSED.keys())
def test_a_bad_status_is_refused_with_its_reason(payload, reason):
    with pytest.raises(MessageError, match=reason):
        RobotStatus.from_json(payload)


@pytest.mark.parametrize("missing", ["robot_id", "task"])
def test_an_assignment_without_a_field_is_refused_by_name(missing):
    fields = {"robot_id": "robot_1", "task": "t"}
    del fields[missing]

    with pytest.raises(MessageError, match=f"field '{missing}' is missing"):
        TaskAssignment.from_json(json.dumps(fields))


def test_the_report_reads_as_in_the_scenario():
    counts = {"robot_1": 3, "robot_2": 1, "robot_3": 4}

    expected = "Fleet report -- robot_1: 3 tasks, robot_2: 1 tasks, robot_3: 4 tasks"
    assert report_text(counts) == expected


def test_a_good_payload_is_shown_as_it_is():
    assert one_line('{"robot_id": "robot_1"}') == '{"robot_id": "robot_1"}'


@given(st.text(max_size=2 * MAX_SHOWN_CHARS))
def test_any_payload_is_shown_on_one_short_line(payload):
    line = one_line(payload)

    assert len(line.splitlines()) <= 1
    assert len(line) <= MAX_SHOWN_CHARS + len("... (9999 characters)")
