"""Orders as JSON, for the agent on a host and for the record of a run there."""

from __future__ import annotations

import base64
import signal
from collections.abc import Callable, Mapping
from typing import Any

from launcher.base.model.spec import Limits, RestartMode, RestartPolicy, StopPolicy
from launcher.base.text import typed_error
from launcher.hosts.file.order import Order
from launcher.hosts.file.references import (
    ExecutableReference,
    Inherited,
    InterpreterReference,
    Part,
    SentFile,
    SharedFile,
    Word,
)

_KINDS: Mapping[str, type] = {
    "executable": ExecutableReference,
    "share": SharedFile,
    "sent": SentFile,
    "python": InterpreterReference,
    "inherited": Inherited,
}
_NAMES = {kind: name for name, kind in _KINDS.items()}


def encode(order: Order) -> dict[str, Any]:
    """What JSON takes; values of variables and contents of files are in it."""
    return {
        "name": order.name,
        "label": order.label,
        "words": [_word(word) for word in order.words],
        "environment": dict(order.environment),
        "variables": {name: _word(word) for name, word in order.variables.items()},
        "unset": list(order.unset),
        "files": {name: base64.b64encode(data).decode() for name, data in order.files.items()},
        "marks": {mark: _part(shared) for mark, shared in order.marks.items()},
        "cwd": order.cwd,
        "cwd_in_share": None if order.cwd_in_share is None else _part(order.cwd_in_share),
        "shell": order.shell,
        "emulate_tty": order.emulate_tty,
        "merge": order.merge,
        "restart": {**_fields(order.restart), "mode": order.restart.mode.value},
        "stop": {**_fields(order.stop), "polite": _polite(order.stop)},
        "limits": None if order.limits is None else _fields(order.limits),
        "number": order.number,
    }


def decode(document: Mapping[str, Any]) -> Order:
    """The order that was encoded; ValueError for anything else."""
    try:
        return Order(**{name: _READ.get(name, _same)(document[name]) for name in Order._fields})
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise ValueError(f"not an order: {typed_error(error)}") from None


def _same(value: Any) -> Any:
    return value


# ---- words


def _word(word: Word) -> list[Any]:
    return [_part(part) for part in word]


def _part(part: Part) -> Any:
    return part if isinstance(part, str) else [_NAMES[type(part)], *part._values()]


def _read_word(value: Any) -> Word:
    return tuple(_read_part(part) for part in value)


def _read_part(value: Any) -> Any:
    return value if isinstance(value, str) else _KINDS[value[0]](*value[1:])


# ---- policies


def _fields(record: Any) -> dict[str, Any]:
    return dict(zip(record._fields, record._values(), strict=True))


def _polite(stop: StopPolicy) -> list[Any] | None:
    return None if stop.polite is None else [[int(signum), wait] for signum, wait in stop.polite]


def _read_restart(value: Any) -> RestartPolicy:
    return RestartPolicy(**{**value, "mode": RestartMode(value["mode"])})


def _read_stop(value: Any) -> StopPolicy:
    steps = value["polite"]
    polite = None if steps is None else tuple((signal.Signals(n), wait) for n, wait in steps)
    return StopPolicy(**{**value, "polite": polite})


def _read_limits(value: Any) -> Limits | None:
    if value is None:
        return None
    cpus = value["cpus"]
    return Limits(
        nice=value["nice"],
        cpus=None if cpus is None else tuple(cpus),
        rlimits=tuple((name, soft, hard) for name, soft, hard in value["rlimits"]),
    )


_READ: Mapping[str, Callable[[Any], Any]] = {
    "words": lambda value: tuple(map(_read_word, value)),
    "variables": lambda value: {name: _read_word(word) for name, word in value.items()},
    "unset": tuple,
    "files": lambda value: {name: base64.b64decode(data) for name, data in value.items()},
    "marks": lambda value: {mark: _read_part(part) for mark, part in value.items()},
    "cwd_in_share": lambda value: None if value is None else _read_part(value),
    "restart": _read_restart,
    "stop": _read_stop,
    "limits": _read_limits,
}
