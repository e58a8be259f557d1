"""Types: which message and service types a script names, and whether they are installed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

from launcher.ros.errors import VerbError
from launcher.ros.messages import interfaces
from launcher.smoke.expectation import Expectation
from launcher.smoke.script import Script


class UnknownTypeError(Exception):
    """There is no such type; `message` and `hint` as in other errors.

    `is_missing`: its whole package is not installed here, so that it may exist elsewhere.
    """

    def __init__(self, message: str, hint: str | None, *, is_missing: bool) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        self.is_missing = is_missing


def load(name: str, kind: str) -> Any:
    """The class of `pkg/msg/Name`, None if its package is broken; UnknownTypeError."""
    try:
        return interfaces.load(name, kind, f"there is no type {name}")
    except VerbError as error:
        raise _unknown(name, kind, error) from None
    except Exception:  # code of others; the probe, which needs it as well, will tell
        return None


def _unknown(name: str, kind: str, error: VerbError) -> UnknownTypeError:
    package = name.partition("/")[0]
    known = interfaces.interface_packages()
    if package in known or not package.isidentifier():
        hint = error.hint if "did you mean" in (error.hint or "") else _offers(package, kind)
        return UnknownTypeError(error.message, hint, is_missing=False)
    near = difflib.get_close_matches(package, known, n=1)
    same = f"{near[0]}/{kind}/{name.rpartition('/')[2]}" if near else ""
    pip = f"python -m pip install ros-{package.replace('_', '-')}, or source its workspace"
    is_near = same in (interfaces.interfaces_of(near[0], [kind]) if near else ())
    return UnknownTypeError(
        f"the package '{package}' of {name} is not installed",
        f"did you mean {same}?" if is_near else pip,
        is_missing=True,
    )


def _offers(package: str, kind: str) -> str | None:
    names = [full.rpartition("/")[2] for full in interfaces.interfaces_of(package, [kind])]
    return f"{package} has {', '.join(names[:12])}{' ...' * (len(names) > 12)}" if names else None


def of_topics(script: Script) -> dict[str, str]:
    """Topic -> type, as far as the script says and is of one mind about it."""
    said: dict[str, set[str]] = {}
    for topic, name in _said(script):
        said.setdefault(topic, set()).add(name)
    return {topic: min(names) for topic, names in said.items() if len(names) == 1}


def _said(script: Script) -> Iterable[tuple[str, str]]:
    for expectation in script.expectations:
        if is_of_topic(expectation) and expectation.get("type"):
            yield expectation.subject, expectation.get("type")
    for step in script.steps:
        if step.command.verb == "publish":
            yield step.command.words["topic"], full_name(step.command.words["type"], "msg")


def is_of_topic(expectation: Expectation) -> bool:
    """Whether its subject is a topic that it may name the type of."""
    return expectation.kind in ("topic", "rate", "message")


def full_name(name: str, kind: str) -> str:
    """`std_msgs/msg/String` of `std_msgs/String`."""
    package, _, rest = name.partition("/")
    return name if "/" in rest else f"{package}/{kind}/{rest}"
