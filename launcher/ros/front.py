"""Options of ROS verbs in front of the verb: `-d 83 topic list`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from launcher.base.command_front import take_front
from launcher.base.errors import UsageError
from launcher.base.option import WORKSPACE
from launcher.base.program import program
from launcher.base.verb_table import ABSENT_VERBS, CONTROL_VERBS, ROS_VERBS, VERBS
from launcher.ros.verb import DOMAIN_OPTIONS

_VERBS = (*VERBS, *CONTROL_VERBS, *ABSENT_VERBS)
_LOOKING = tuple(verb for verb in ROS_VERBS if verb not in ("multicast", "daemon"))  # at a graph
_SHORT = re.compile(r"-d(\d+)$")


def verb_first(words: Sequence[str]) -> list[str]:
    """The same command line with its verb in front of such options; UsageError.

    Left as it is: a command line that begins with options of a launch.
    """
    metavars = {flag: one.metavar for one in (*DOMAIN_OPTIONS, WORKSPACE) for flag in one.flags}
    spelled = list(words)
    if words and (short := _SHORT.match(words[0])) is not None:
        spelled[:1] = ["-d", short[1]]
    del metavars["-d"]
    _, rest = take_front(spelled, metavars)
    metavars["-d"] = "ID" if rest[:1] == ["-d"] and _is_domain(rest[1:]) else ""
    front, rest = take_front(spelled, metavars)
    if not front:
        return list(words)
    flags = [option[0].partition("=")[0] for option in front]
    valued = [flag for flag in flags if metavars[flag] and flag not in WORKSPACE.flags]
    if valued:
        _require_ros_verb(valued[0], rest)
    elif not rest or rest[0] not in _VERBS:
        return list(words)
    place = 1
    if rest[0] == "bag":  # -d is something else, and not all of its verbs look at a graph
        front = [["--domain", *option[1:]] if option[0] == "-d" else option for option in front]
        place = 2
    return [*rest[:place], *(part for option in front for part in option), *rest[place:]]


def _is_domain(behind: Sequence[str]) -> bool:
    """Whether `-d` in front of these words is a domain; `-d system` is --debug of a launch."""
    if behind and behind[0] in _LOOKING:
        example = f"{program()} -d 83 {' '.join(behind[:2])}"
        raise UsageError("-d needs a value: ID", hint=f"for example: {example}")
    return any(one.isdigit() for one in behind[:1]) or any(one in _LOOKING for one in behind[1:2])


def _require_ros_verb(flag: str, rest: Sequence[str]) -> None:
    verbs = f"it is an option of {', '.join(_LOOKING)}"
    if not rest:
        raise UsageError(f"the verb behind {flag} is missing", hint=verbs)
    if rest[0].startswith("-"):
        raise UsageError(f"unknown option '{rest[0]}' in front of the verb", hint=verbs)
    if rest[0] in _LOOKING or rest[0] in ABSENT_VERBS:
        return
    if rest[0] in _VERBS:
        raise UsageError(f"{flag} is not an option of '{rest[0]}'", hint=verbs)
    from launcher.base.synonyms import meant_verb  # only mistakes need it

    hint = meant_verb(rest[0], _VERBS) or verbs
    raise UsageError(f"unknown verb '{rest[0]}' behind {flag}", hint=hint)
