"""The message and service types of a script, and whether they are installed."""

from __future__ import annotations

from typing import Any

from launcher.base.errors import LauncherError
from launcher.base.ros_errors import VerbError
from launcher.base.text import suggest
from launcher.ros.messages import interfaces
from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.expect.expectation_kinds import OF_MESSAGES
from launcher.smoke.expect.script import Script


class UnknownTypeError(LauncherError):
    """`is_missing`: the package is not installed, so that the type may exist elsewhere."""

    def __init__(self, message: str, hint: str | None, *, is_missing: bool) -> None:
        super().__init__(message, hint=hint)
        self.is_missing = is_missing


def load(name: str, kind: str) -> Any:
    """The class of `pkg/msg/Name`, None if its package is broken; UnknownTypeError."""
    try:
        return interfaces.load(name, kind, f"unknown type {name}")
    except VerbError as error:
        raise _unknown(name, kind, error) from None
    except Exception:  # the import of the package failed; the probe will report it
        return None


def _unknown(name: str, kind: str, error: VerbError) -> UnknownTypeError:
    package = name.partition("/")[0]
    known = interfaces.interface_packages()
    if package in known or not package.isidentifier():
        hint = error.hint if "did you mean" in (error.hint or "") else _offers(package, kind)
        return UnknownTypeError(error.message, hint, is_missing=False)
    near = suggest(package, known)
    same = f"{near}/{kind}/{name.rpartition('/')[2]}"
    pip = f"python -m pip install ros-{package.replace('_', '-')}, or source its workspace"
    is_near = near is not None and same in interfaces.interfaces_of(near, [kind])
    return UnknownTypeError(
        f"the package '{package}' of {name} is not installed",
        f"did you mean {same}?" if is_near else pip,
        is_missing=True,
    )


def _offers(package: str, kind: str) -> str | None:
    names = [full.rpartition("/")[2] for full in interfaces.interfaces_of(package, [kind])]
    return f"{package} has {', '.join(names[:12])}{' ...' * (len(names) > 12)}" if names else None


def of_topics(script: Script) -> dict[str, str]:
    """Topic -> type, where the script names exactly one."""
    named = [(e.subject, e.get("type")) for e in script.expectations if is_of_topic(e)]
    for step in script.steps:
        words = step.command.words
        if step.command.verb == "publish":
            named.append((words["topic"], full_name(words["type"], "msg")))
    types: dict[str, set[str]] = {}
    for topic, name in named:
        if name is not None:
            types.setdefault(topic, set()).add(name)
    return {topic: min(names) for topic, names in types.items() if len(names) == 1}


def is_of_topic(expectation: Expectation) -> bool:
    """Whether its subject is a topic with an optional type."""
    return expectation.kind in ("topic", *OF_MESSAGES)


def full_name(name: str, kind: str) -> str:
    """`std_msgs/msg/String` of `std_msgs/String`."""
    package, _, rest = name.partition("/")
    return name if "/" in rest else f"{package}/{kind}/{rest}"
