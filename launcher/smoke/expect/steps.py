"""Steps: what a scenario does to the system, and when."""

from __future__ import annotations

import re
import signal
from dataclasses import dataclass, field
from typing import Any

from launcher.smoke.expect.expectation import COMMAND_LINE
from launcher.smoke.expect.fields import FieldError, near
from launcher.smoke.expect.quantities import DURATION, for_editors
from launcher.smoke.expect.source_location import Origin
from launcher.smoke.observe.facts import START

SIGNAL = r"SIG[A-Z0-9]+"


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """What is done; `words` depend on the verb: names, a topic, its type, a value."""

    verb: str
    text: str
    words: dict[str, Any] = field(default_factory=dict)

    @property
    def needs_ros(self) -> bool:
        """Whether the probe does it."""
        return self.verb in ("publish", "set", "call")


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """`command` is done `delay_s` after the step `after`, or after a line that matches `after_log`
    (which is looked for from the step `after` on).
    """

    name: str
    command: Command
    delay_s: float = 0.0
    after: str = START
    after_log: re.Pattern[str] | None = None
    process: str | None = None
    origin: Origin = COMMAND_LINE

    @property
    def done(self) -> str:
        """The name of the moment at which it has been done."""
        return f"{self.name}: done"

    @property
    def over(self) -> str:
        """The name of the moment at which a pause is over."""
        return f"{self.name}: over"

    @property
    def moments(self) -> tuple[str, ...]:
        """What `after` may name: its beginning, when it is done, the end of a pause."""
        is_pause = self.command.verb == "pause" and "time_s" in self.command.words
        return (self.name, self.done, *((self.over,) if is_pause else ()))


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
CHAOS_EXAMPLE = "kill one of robot_* every 5 s"
_CHAOS = re.compile(
    r"(?P<verb>kill|stop|restart|pause) +one +of +(?P<name>\S+) +every +(?P<every>[^a-z]+[a-z]*)"
    r"(?: +for +(?P<time>\S.*))?"
)


class CommandType:
    """A command of a scenario as text."""

    def parse(self, value: object) -> Command:
        """ValueError with a sentence."""
        if not isinstance(value, str) or not value.strip():
            raise FieldError(f"{value!r} is no command, as in 'kill robot_2'")
        verb, _, rest = value.strip().partition(" ")
        if verb not in _VERBS:
            raise FieldError(f"nothing is called '{verb}'", hint=near(verb, list(_VERBS)))
        pattern, example = _VERBS[verb]
        match = re.fullmatch(pattern, rest.strip())
        if match is None:
            raise FieldError(f"'{value}' is no command to {verb}", hint=f"as in '{example}'")
        words = {name: word for name, word in match.groupdict().items() if word is not None}
        return Command(verb=verb, text=value.strip(), words=_with_values(verb, words))

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"anyOf": [_verb_schema(verb, pattern) for verb, (pattern, _) in _VERBS.items()]}


def _verb_schema(verb: str, pattern: str) -> dict[str, object]:
    plain = for_editors(pattern)
    example = _VERBS[verb][1]
    return {"type": "string", "pattern": f"^ *{verb} +(?:{plain}) *$", "examples": [example]}


def _with_values(verb: str, words: dict[str, str]) -> dict[str, Any]:
    values: dict[str, Any] = dict(words)
    if "time" in words:
        values["time_s"] = DURATION.parse(words["time"])
    if verb == "kill":
        values["signal"] = _signal(words.get("signal", "SIGKILL"))
    if "value" in words:
        values["value"] = _yaml(words["value"])
    return values


def _signal(name: str) -> str:
    known = list(signal.Signals.__members__)
    if name not in known:
        raise FieldError(f"there is no signal '{name}'", hint=near(name, known))
    return name


def _yaml(text: str) -> Any:
    import yaml

    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        reason = getattr(error, "problem", None) or error
        raise FieldError(f"'{text}' is no YAML: {reason}") from None


@dataclass(frozen=True, slots=True, kw_only=True)
class Chaos:
    """`verb` is done to one of the processes that `pattern` means, every `every_s`."""

    verb: str
    pattern: str
    every_s: float
    text: str
    time_s: float | None = None
    seed: int = 0


class ChaosType:
    """What chaos does, as text."""

    def parse(self, value: object) -> Chaos:
        """ValueError with a sentence."""
        match = _CHAOS.fullmatch(value.strip()) if isinstance(value, str) else None
        if match is None:
            raise FieldError(f"{value!r} is no chaos", hint=f"as in '{CHAOS_EXAMPLE}'")
        every_s = DURATION.parse(match["every"].strip())
        if every_s <= 0:
            raise FieldError("chaos needs a time between its strokes")
        time_s = DURATION.parse(match["time"]) if match["time"] else None
        return Chaos(
            verb=match["verb"],
            pattern=match["name"],
            every_s=every_s,
            text=match[0],
            time_s=time_s,
        )

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        duration = DURATION.pattern
        pattern = (
            rf"^ *(?:kill|stop|restart|pause) +one +of +\S+ +every +(?:{duration})"
            rf"(?: +for +(?:{duration}))? *$"
        )
        return {
            "type": "string",
            "pattern": for_editors(pattern),
            "examples": [CHAOS_EXAMPLE],
        }
