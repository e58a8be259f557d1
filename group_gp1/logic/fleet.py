"""
Which robots a warehouse has: read from a fleet file, or generated.

Launch files import this, also with a ROS 2 installation: nothing here needs rclpy.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
import difflib
import random
import re
from typing import Any

import yaml

MAX_ROBOTS = 500
MAX_DURATION_S = 3600.0
_DRAWN_S = (0.3, 2.0)  # the task durations of robots of which none is given
_ID = re.compile(r'[A-Za-z][A-Za-z0-9_]{0,99}')  # a valid name of a node
_TAKEN = ('dispatcher', 'monitor', 'debug_logger')


class FleetError(ValueError):
    """A fleet that cannot be; the text has the place of each mistake, and what to write."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetRobot:
    """One robot, as its node gets it in parameters."""

    robot_id: str
    task_duration_s: float
    task_spread: float = 0.0
    status_period_s: float = 1.0
    seed: int = 0

    def parameters(self) -> dict[str, Any]:
        return {
            'task_duration_s': self.task_duration_s,
            'task_spread': self.task_spread,
            'status_period_s': self.status_period_s,
            'seed': self.seed,
        }

    @property
    def longest_silence_s(self) -> float:
        """Between two statuses: none is sent while a task is executed."""
        return self.task_duration_s * (1.0 + self.task_spread) + self.status_period_s


def generate(robots: int, seed: int) -> list[FleetRobot]:
    """`robot_001` and so on; the duration of a robot depends on its id and the seed only."""
    if not 1 <= robots <= MAX_ROBOTS:
        raise FleetError(f'robots is {robots}, and not a number from 1 to {MAX_ROBOTS}')
    digits = max(3, len(str(robots)))
    ids = (f'robot_{number:0{digits}}' for number in range(1, robots + 1))
    return [
        FleetRobot(robot_id=one, task_duration_s=drawn_duration_s(one, seed), seed=seed)
        for one in ids
    ]


def drawn_duration_s(robot_id: str, seed: int) -> float:
    """Draw the same for the same robot, whatever other robots there are."""
    return round(random.Random(f'{seed}:{robot_id}').uniform(*_DRAWN_S), 2)


def read(path: str, seed: int = 0) -> list[FleetRobot]:
    """Read a fleet file; FleetError with all of its mistakes. `seed`: if it has none."""
    try:
        with open(path, encoding='utf-8') as file:
            root = yaml.compose(file, Loader=yaml.SafeLoader)
    except OSError as error:
        raise FleetError(f"cannot read the fleet file '{path}': {error.strerror}") from None
    except UnicodeDecodeError:
        raise FleetError(f"the fleet file '{path}' is not text in UTF-8") from None
    except RecursionError:
        raise FleetError(f"the fleet file '{path}' is nested too deeply") from None
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        line = f':{mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or 'this is not YAML'
        raise FleetError(f'{path}{line}: {problem}') from None
    return _Reader(path).fleet(root, seed)


@dataclass(frozen=True, slots=True)
class _Number:
    """A kind of value: what it may be, in words and in numbers."""

    low: float
    high: float
    whole: bool = False

    def __str__(self) -> str:
        return f'a{" whole" * self.whole} number from {self.low:g} to {self.high:g}'

    def read(self, value: object) -> float | int | None:
        """None if it is not such a number."""
        kinds = (int,) if self.whole else (int, float)
        if isinstance(value, bool) or not isinstance(value, kinds):
            return None
        if not self.low <= value <= self.high:
            return None
        return value if self.whole else float(value)


_SETTINGS = {
    'task_duration_s': _Number(0.0, MAX_DURATION_S),
    'task_spread': _Number(0.0, 1.0),
    'status_period_s': _Number(0.05, 60.0),
    'seed': _Number(0, 2**31 - 1, whole=True),
}
_OF_FLEET = ('robots', *_SETTINGS)
_OF_ROBOT = ('id', *_SETTINGS)


class _Reader:
    """Reads the nodes of a YAML document, and collects mistakes with their lines."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._mistakes: list[tuple[int, str]] = []

    def fleet(self, root: Any, seed: int) -> list[FleetRobot]:
        entries = self._mapping(root, _OF_FLEET, 'a fleet file')
        given = {'seed': seed, **self._settings(entries)}
        robots = list(self._robots(entries.get('robots'), given)) if entries else []
        if entries and 'robots' not in entries:
            self._add(root, "a fleet file needs 'robots': robots: [{id: robot_1}, {id: robot_2}]")
        if self._mistakes:
            lines = (f'{self._path}:{line}: {text}' for line, text in sorted(self._mistakes))
            raise FleetError('\n'.join(lines))
        return robots

    def _robots(self, node: Any, given: dict[str, Any]) -> Iterator[FleetRobot]:
        if node is None:
            return
        if not isinstance(node, yaml.SequenceNode) or not node.value:
            self._add(node, "'robots' is a list with at least one robot, as in - {id: robot_1}")
            return
        if len(node.value) > MAX_ROBOTS:
            self._add(
                node, f'{len(node.value)} robots, and more than {MAX_ROBOTS} are not possible'
            )
            return
        lines: dict[str, int] = {}
        for one in node.value:
            robot = self._robot(one, given, lines)
            if robot is not None:
                yield robot

    def _robot(self, node: Any, given: dict[str, Any], lines: dict[str, int]) -> FleetRobot | None:
        is_id = isinstance(node, yaml.ScalarNode)
        entries = {'id': node} if is_id else self._mapping(node, _OF_ROBOT, 'a robot')
        if 'id' not in entries:
            if entries:
                self._add(node, "a robot needs 'id', the name of its node")
            return None
        robot_id = self._id(entries['id'], lines)
        settings = {**given, **self._settings(entries)}
        if robot_id is None:
            return None
        settings.setdefault('task_duration_s', drawn_duration_s(robot_id, settings['seed']))
        return FleetRobot(robot_id=robot_id, **settings)

    def _id(self, node: Any, lines: dict[str, int]) -> str | None:
        name = str(node.value) if isinstance(node, yaml.ScalarNode) else None
        if name is None or not _ID.fullmatch(name):
            shown = 'this' if name is None else f"'{name}'"
            message = f'{shown} is no id of a robot: letters, digits and _, and a letter first'
            valid = re.sub(r'\W', '_', name or '', flags=re.ASCII)
            hint = f'; did you mean {valid}?' if _ID.fullmatch(valid) else ''
            self._add(node, message + hint)
        elif name in _TAKEN:
            self._add(node, f"'{name}' is the name of another node of the fleet")
        elif name in lines:
            self._add(node, f"'{name}' is already the id of the robot in line {lines[name]}")
        else:
            lines[name] = _line(node)
            return name
        return None

    def _settings(self, entries: dict[str, Any]) -> dict[str, Any]:
        found = {}
        for name, kind in _SETTINGS.items():
            if name not in entries:
                continue
            node = entries[name]
            value = kind.read(_plain(node))
            if value is None:
                shown = f"'{node.value}'" if isinstance(node, yaml.ScalarNode) else 'this'
                self._add(node, f'{name}: {shown} is not {kind}')
            else:
                found[name] = value
        return found

    def _mapping(self, node: Any, known: Iterable[str], what: str) -> dict[str, Any]:
        if not isinstance(node, yaml.MappingNode):
            self._add(node, f'{what} is a mapping with: {", ".join(known)}')
            return {}
        found: dict[str, Any] = {}
        for key, value in node.value:
            name = str(key.value)
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                hint = f"did you mean '{near[0]}'?" if near else f'known: {", ".join(known)}'
                self._add(key, f"{what} has no '{name}'; {hint}")
            elif name in found:
                self._add(key, f"'{name}' is here twice")
            found.setdefault(name, value)
        return found

    def _add(self, node: Any, text: str) -> None:
        self._mistakes.append((_line(node), text))


def _line(node: Any) -> int:
    return 1 if node is None else int(node.start_mark.line) + 1


def _plain(node: Any) -> object:
    """Return the value of a scalar, None for anything else."""
    if not isinstance(node, yaml.ScalarNode):
        return None
    return yaml.SafeLoader('').construct_object(node)
