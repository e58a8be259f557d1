"""
The payloads of the fleet: JSON texts in `std_msgs/msg/String`, checked field by field.

Fields of the scenario are required. Fields that this fleet adds (`task_id`, `completed`) may be
absent, so that a person can publish an assignment by hand; fields it does not know are ignored.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import enum
import json
from typing import Any

MAX_PAYLOAD_CHARS = 4096  # ten times the longest payload of the fleet
MAX_SHOWN_CHARS = 500  # of a payload in the log; any payload of the fleet itself is shorter
MAX_TEXT_CHARS = 128  # of a name in a payload; it goes into log lines
RECENTLY_COMPLETED = 10  # tasks listed in each status; see RobotStatus.completed


class MessageError(ValueError):
    """An invalid payload; the text names the field and the reason."""


class Status(str, enum.Enum):
    BUSY = 'busy'
    DONE = 'done'


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskAssignment:
    """
    One task for one robot.

    `task_id` is `<dispatcher run>-<number>`: it stays unique when either side starts again.
    None means that the publisher gave none.
    """

    robot_id: str
    task: str
    task_id: str | None = None

    def to_json(self) -> str:
        """Return the payload for `/fleet/tasks`."""
        fields = {'robot_id': self.robot_id, 'task': self.task}
        if self.task_id is not None:
            fields['task_id'] = self.task_id
        return json.dumps(fields)

    @classmethod
    def from_json(cls, payload: str) -> TaskAssignment:
        """Read a payload; raises MessageError."""
        fields = _object(payload)
        return cls(
            robot_id=_text(fields, 'robot_id'),
            task=_text(fields, 'task'),
            task_id=_text(fields, 'task_id') if 'task_id' in fields else None,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotStatus:
    """
    What a robot does now, and its last completed tasks.

    A robot that never had a task is `done` with an empty `task`. `completed` holds the ids of the
    last tasks it finished, oldest first, at most RECENTLY_COMPLETED: status is BEST_EFFORT, so a
    next status makes up for a lost `done`. None means that the sender does not list them.
    """

    robot_id: str
    status: Status
    task: str
    task_id: str | None = None
    completed: tuple[str, ...] | None = None

    def to_json(self) -> str:
        """Return the payload for `/fleet/status`."""
        fields: dict[str, Any] = {
            'robot_id': self.robot_id,
            'status': self.status.value,
            'task': self.task,
        }
        if self.task_id is not None:
            fields['task_id'] = self.task_id
        if self.completed is not None:
            fields['completed'] = list(self.completed)
        return json.dumps(fields)

    @classmethod
    def from_json(cls, payload: str) -> RobotStatus:
        """Read a payload; raises MessageError."""
        fields = _object(payload)
        status = _status(fields)
        return cls(
            robot_id=_text(fields, 'robot_id'),
            status=status,
            task=_text(fields, 'task', may_be_empty=status is Status.DONE),
            task_id=_text(fields, 'task_id') if 'task_id' in fields else None,
            completed=_completed(fields) if 'completed' in fields else None,
        )


def report_text(counts: Mapping[str, int]) -> str:
    """Return the line of `/fleet/report`."""
    parts = (f'{robot_id}: {count} tasks' for robot_id, count in counts.items())
    return f'Fleet report -- {", ".join(parts)}'


def one_line(payload: str) -> str:
    """Shorten a payload to one line for the log; a well-formed one is unchanged."""
    line = payload if payload.isprintable() else repr(payload)
    if len(line) <= MAX_SHOWN_CHARS:
        return line
    return f'{line[:MAX_SHOWN_CHARS]}... ({len(payload)} characters)'


def _object(payload: str) -> dict[str, Any]:
    if len(payload) > MAX_PAYLOAD_CHARS:
        raise MessageError(f'{len(payload)} characters, more than {MAX_PAYLOAD_CHARS}')
    try:
        value = json.loads(payload)
    except (ValueError, RecursionError) as error:  # the latter: thousands of nested brackets
        raise MessageError(f'not JSON: {error}') from None
    if not isinstance(value, dict):
        raise MessageError(f'not a JSON object but {_kind(value)}')
    return value


def _text(fields: Mapping[str, Any], name: str, *, may_be_empty: bool = False) -> str:
    value = _required(fields, name)
    if not isinstance(value, str):
        raise MessageError(f"field '{name}' must be a string, not {_kind(value)}")
    if not value and not may_be_empty:
        raise MessageError(f"field '{name}' is empty")
    if len(value) > MAX_TEXT_CHARS:
        raise MessageError(f"field '{name}' is longer than {MAX_TEXT_CHARS} characters")
    if not value.isprintable():  # a line break could fake a line of the log
        raise MessageError(f"field '{name}' has characters that cannot be printed")
    return value


def _status(fields: Mapping[str, Any]) -> Status:
    text = _text(fields, 'status')
    try:
        return Status(text)
    except ValueError:
        raise MessageError(f"field 'status' must be busy or done, not '{text}'") from None


def _completed(fields: Mapping[str, Any]) -> tuple[str, ...]:
    value = fields['completed']
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise MessageError("field 'completed' must be an array of strings")
    if len(value) > RECENTLY_COMPLETED:
        raise MessageError(f"field 'completed' has more than {RECENTLY_COMPLETED} entries")
    return tuple(value)


def _required(fields: Mapping[str, Any], name: str) -> Any:
    if name not in fields:
        raise MessageError(f"field '{name}' is missing")
    return fields[name]


def _kind(value: object) -> str:
    kinds = {
        dict: 'an object',
        list: 'an array',
        str: 'a string',
        bool: 'a boolean',
        type(None): 'null',
    }
    return kinds.get(type(value), 'a number')
