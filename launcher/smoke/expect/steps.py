"""Steps of a scenario: commands to the system, and when they are run."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from launcher.base.document.fields import FieldError, FieldType, near
from launcher.base.document.quantities import DURATION, DURATION_PATTERN, for_editors
from launcher.base.document.source_location import Origin
from launcher.base.model.parameter_text import read
from launcher.base.synonyms import meant_verb
from launcher.smoke.expect.expectation import COMMAND_LINE, START
from launcher.smoke.inject.grammar import EXAMPLE, MACHINE, parsed_line, patterns


@dataclass(frozen=True, slots=True, kw_only=True)
class StepCommand:
    """`words` depend on the verb: names, a topic, its type, a value."""

    verb: str
    text: str
    words: dict[str, Any] = field(default_factory=dict)

    @property
    def needs_ros(self) -> bool:
        return self.verb in ("publish", "set", "call")


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """`command` is run `delay_s` after the step `after`, or after the first line since that step
    that matches `after_log` (of `process`, if given).
    """

    name: str
    command: StepCommand
    delay_s: float = 0.0
    after: str = START
    after_log: re.Pattern[str] | None = None
    process: str | None = None
    origin: Origin = COMMAND_LINE

    @property
    def done(self) -> str:
        return f"{self.name}: done"

    @property
    def over(self) -> str:
        return f"{self.name}: over"

    @property
    def pause_s(self) -> float:
        return float(self.command.words.get("time_s") or 0.0)

    @property
    def moments(self) -> tuple[str, ...]:
        """What `after` may name: start and completion of the command, and the end of its time."""
        lasts = self.command.words.get("time_s") is not None
        return (self.name, self.done, *((self.over,) if lasts else ()))


_VERBS: dict[str, tuple[str, str]] = {
    "kill": (r"(?P<name>\S+)(?: +(?:with +)?(?P<signal>SIG[A-Z0-9]+))?", "kill robot_2 [SIGKILL]"),
    "stop": (r"(?P<name>\S+)", "stop robot_2"),
    "start": (r"(?P<name>\S+)", "start robot_2"),
    "restart": (r"(?P<name>\S+)", "restart robot_2"),
    "pause": (r"(?P<name>\S+)(?: +for +(?P<time>\S.*))?", "pause robot_1 for 3 s"),
    "resume": (r"(?P<name>\S+)", "resume robot_1"),
    "send": (r"(?P<name>\S+) +(?P<text>\S.*)", "send robot_1 hello"),
    "publish": (
        r"(?P<topic>/\S*) +(?P<type>\S+/\S+) +(?P<value>\S.*)",
        "publish /chatter std_msgs/msg/String {data: hello}",
    ),
    "set": (
        r"(?:parameter +)?(?P<node>/\S*) +(?P<parameter>[^\s/]\S*) +(?P<value>\S.*)",
        "set /robot_1 task_duration_s 0.5",
    ),
    "call": (
        r"(?:service +)?(?P<service>/\S*) +(?P<type>\S+/\S+)(?: +(?P<value>\S.*))?",
        "call /switch std_srvs/srv/SetBool {data: true}",
    ),
}
INJECT = "inject"
CHAOS_EXAMPLE = "kill one of robot_* every 5 s"
_CHAOS = re.compile(
    r"(?P<verb>kill|stop|restart|pause) +one +of +(?P<name>\S+) +every +(?P<every>[^a-z]+[a-z]*)"
    r"(?: +for +(?P<time>\S.*))?"
)


def _parse_command(value: object) -> StepCommand:
    if not isinstance(value, str) or not value.strip():
        raise FieldError(f"invalid command {value!r}: expected one such as 'kill robot_2'")
    verb, _, rest = value.strip().partition(" ")
    if verb == INJECT:
        return _injection(value.strip(), rest)
    if verb not in _VERBS:
        known = (*_VERBS, INJECT)
        hint = meant_verb(verb, known) or f"known: {', '.join(known)}"
        raise FieldError(f"unknown command '{verb}'", hint=hint)
    pattern, example = _VERBS[verb]
    match = re.fullmatch(pattern, rest.strip())
    if match is None:
        raise FieldError(f"invalid command '{value}'", hint=f"as in '{example}'")
    words: dict[str, Any] = {n: word for n, word in match.groupdict().items() if word is not None}
    if "time" in words:
        words["time_s"] = DURATION.parse(words["time"])
    if verb == "kill":
        words["signal"] = _signal(words.get("signal", "SIGKILL"))
    if "value" in words:
        words["value"] = _value(words["value"], read if verb == "set" else _plain)
    return StepCommand(verb=verb, text=value.strip(), words=words)


def _injection(text: str, line: str) -> StepCommand:
    """As `launcher inject`: of a process, or of the machine, which has no name then."""
    if not line.strip():
        raise FieldError(f"invalid command '{text}'", hint=f"as in '{INJECT} {EXAMPLE}'")
    name, injection = parsed_line(line)
    words = {"injection": injection, "time_s": injection.for_s}
    return StepCommand(
        verb=INJECT, text=text, words=words if name == MACHINE else {"name": name, **words}
    )


def _signal(name: str) -> str:
    known = list(signal.Signals.__members__)
    if name not in known:
        raise FieldError(f"unknown signal '{name}'", hint=near(name, known))
    return name


def _plain(text: str) -> Any:
    from launcher.base import yaml_bounds

    return yaml_bounds.load(text)


def _value(text: str, load: Callable[[str], Any]) -> Any:
    import yaml

    try:
        return load(text)
    except yaml.YAMLError as error:
        reason = getattr(error, "problem", None) or error
        raise FieldError(f"invalid YAML '{text}': {reason}") from None


def _text_schema(pattern: str, example: str) -> dict[str, object]:
    return {"type": "string", "pattern": f"^ *{for_editors(pattern)} *$", "examples": [example]}


COMMAND = FieldType(
    _parse_command,
    {
        "anyOf": [
            _text_schema(rf"{verb} +(?:{pattern})", example)
            for verb, (pattern, example) in _VERBS.items()
        ]
        + [
            _text_schema(rf"{INJECT} +(?:{pattern})", f"{INJECT} {example}")
            for pattern, example in patterns()
        ]
    },
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chaos:
    """Run `verb` on one of the processes that match `pattern`, every `every_s`."""

    verb: str
    pattern: str
    every_s: float
    text: str
    time_s: float | None = None
    seed: int = 0


def _parse_chaos(value: object) -> Chaos:
    match = _CHAOS.fullmatch(value.strip()) if isinstance(value, str) else None
    if match is None:
        raise FieldError(f"invalid chaos {value!r}", hint=f"as in '{CHAOS_EXAMPLE}'")
    every_s = DURATION.parse(match["every"].strip())
    if every_s <= 0:
        raise FieldError("the interval of chaos must be greater than 0 s")
    return Chaos(
        verb=match["verb"],
        pattern=match["name"],
        every_s=every_s,
        text=match[0],
        time_s=DURATION.parse(match["time"]) if match["time"] else None,
    )


def chaos_type() -> FieldType:
    pattern = (
        rf"(?:kill|stop|restart|pause) +one +of +\S+ +every +(?:{DURATION_PATTERN})"
        rf"(?: +for +(?:{DURATION_PATTERN}))?"
    )
    return FieldType(_parse_chaos, _text_schema(pattern, CHAOS_EXAMPLE))


parse_chaos = chaos_type().parse
