"""The words of an injection, such as `slow 4 for 5 s`: of the verb, steps of `smoke`, plans."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from launcher.base.document.fields import FieldError, near
from launcher.base.document.quantities import (
    DURATION,
    DURATION_PATTERN,
    NUMBER,
    PERCENT,
    SIZE,
    for_editors,
)
from launcher.base.model.record import Record, replace
from launcher.smoke.inject.processors import excess, usable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

MACHINE = "machine"  # in place of a process
DEFAULT_S = 5.0
GREATEST_FACTOR = 1000.0
_FOR = re.compile(rf"(?P<what>.*?) +for +(?P<time>{DURATION_PATTERN})")
_TOPIC = r"/\S*[^\s/]"
_SIZE = rf"{NUMBER} *[KMG]?i?B?"


class InjectionArgument(Record):
    """A word behind the kind of an injection; ValueError from `read` if it is none."""

    name: str
    metavar: str
    pattern: str
    read: Callable[[str], Any]
    is_needed: bool = True


class InjectionKind(Record):
    """A kind of injection; `on_machine`: it may also be one of the machine, without a process."""

    name: str
    example: str
    arguments: tuple[InjectionArgument, ...] = ()
    lasts: bool = True
    on_machine: bool = False

    @property
    def usage(self) -> str:
        """`slow FACTOR`."""
        words = (one.metavar if one.is_needed else f"[{one.metavar}]" for one in self.arguments)
        return " ".join([self.name, *words])


def _factor(word: str) -> float:
    value = _number(word)
    if not 1.0 < value <= GREATEST_FACTOR:
        raise FieldError(f"'{word}' is not a factor above 1, up to {GREATEST_FACTOR:g}")
    return value


def _number(word: str) -> float:
    if not re.fullmatch(NUMBER, word):
        raise FieldError(f"'{word}' is not a number")
    return float(word)


def _topic(word: str) -> str:
    if not re.fullmatch(_TOPIC, word):
        raise FieldError(f"'{word}' is not the full name of a topic", hint="as in /robot_1/scan")
    return word


def _percent(word: str) -> float:
    value: float = PERCENT.parse(word)
    if not 0.0 < value <= 100.0:
        raise FieldError(f"'{word}' is not a percentage above 0, up to 100")
    return value


def _delay_s(word: str) -> float:
    """Milliseconds, unless the word has a unit."""
    value: float = DURATION.parse(f"{word}ms" if re.fullmatch(NUMBER, word) else word)
    if value <= 0.0:
        raise FieldError("a delay must be greater than 0 ms")
    return value


def _size(word: str) -> int:
    value: int = SIZE.parse(word)
    if value <= 0:
        raise FieldError(f"'{word}' is not a size above 0")
    return value


def _cores(word: str) -> int:
    if not re.fullmatch(r"[1-9][0-9]{0,3}", word):
        raise FieldError(f"'{word}' is not a number of cores")
    if problem := excess(int(word), usable()):
        raise FieldError(problem)
    return int(word)


_TOPIC_NAME = InjectionArgument("topic", "TOPIC", _TOPIC, _topic)
_KINDS = (
    InjectionKind("pause", "robot_1 pause for 3 s"),
    InjectionKind(
        "slow", "robot_1 slow 4 for 5 s", (InjectionArgument("factor", "FACTOR", NUMBER, _factor),)
    ),
    InjectionKind("kill", "robot_1 kill", lasts=False),
    InjectionKind(
        "drop",
        "robot_1 drop /robot_1/scan 50 % for 5 s",
        (_TOPIC_NAME, InjectionArgument("percent", "PERCENT", rf"{NUMBER} *%?", _percent, False)),
    ),
    InjectionKind(
        "delay",
        "robot_1 delay /robot_1/scan 200 ms for 5 s",
        (_TOPIC_NAME, InjectionArgument("delay_s", "MS", rf"{NUMBER} *(?:ms|s)?", _delay_s)),
    ),
    InjectionKind(
        "cpu",
        "robot_1 cpu 2 for 5 s",
        (InjectionArgument("cores", "CORES", "[1-9][0-9]*", _cores, False),),
        on_machine=True,
    ),
    InjectionKind(
        "memory",
        "robot_1 memory 200 MB for 5 s",
        (InjectionArgument("size", "SIZE", _SIZE, _size),),
        on_machine=True,
    ),
    InjectionKind(
        "disk",
        "machine disk for 5 s",
        (InjectionArgument("leave", "LEAVE", _SIZE, SIZE.parse, False),),
        on_machine=True,
    ),
)
KINDS = {kind.name: kind for kind in _KINDS}
EXAMPLE = _KINDS[1].example


class Injection(Record):
    """What is injected: `values` by the names of arguments; `for_s` is None if it does not last."""

    kind: str
    text: str  # without the time
    values: tuple[tuple[str, Any], ...] = ()
    for_s: float | None = None

    def value(self, name: str) -> Any:
        """The value of an argument; None if it was not given."""
        return dict(self.values).get(name)

    @property
    def on_machine(self) -> bool:
        return KINDS[self.kind].on_machine

    @property
    def topic(self) -> str | None:
        """The topic whose messages it changes."""
        topic: str | None = self.value("topic")
        return topic


def parsed(text: str, for_s: float | None = None) -> Injection:
    """The injection that words such as `slow 4 for 5 s` are, without a name; FieldError.

    `for_s` is how long it lasts where the words have no time, 5 s if it is None.
    """
    words = " ".join(text.split())
    match = _FOR.fullmatch(words)
    if match is not None:
        words, for_s = match["what"], DURATION.parse(match["time"].strip())
    name, _, rest = words.partition(" ")
    kind = KINDS.get(name)
    if kind is None:
        problem = f"unknown injection '{name}'" if name else "it is not said what to inject"
        raise FieldError(problem, hint=near(name, KINDS))
    if for_s is not None and not kind.lasts:
        raise FieldError(f"{name} takes no time: it happens at once")
    if for_s is not None and for_s <= 0.0:
        raise FieldError("the time of an injection must be greater than 0 s")
    lasting_s = for_s or DEFAULT_S
    return Injection(kind.name, words, _values(kind, rest), lasting_s if kind.lasts else None)


def _values(kind: InjectionKind, rest: str) -> tuple[tuple[str, Any], ...]:
    found: list[tuple[str, Any]] = []
    usage = f"usage: {kind.usage}"
    for argument in kind.arguments:
        if not rest:
            if argument.is_needed:
                raise FieldError(f"{kind.name} needs {argument.metavar}", hint=usage)
            break
        # The longest words that fit, since a size may have a blank before its unit.
        match = re.match(rf"(?:{argument.pattern})(?= |$)", rest)
        word = match[0] if match is not None else rest.partition(" ")[0]
        try:
            found.append((argument.name, argument.read(word)))
        except ValueError as error:
            hint = getattr(error, "hint", None) or usage
            raise FieldError(f"{kind.name}: {error}", hint=hint) from None
        rest = rest[len(word) :].lstrip()
    if rest:
        raise FieldError(f"{kind.name}: unexpected '{rest}'", hint=usage)
    return tuple(found)


def parsed_line(line: object) -> tuple[str, Injection]:
    """(the name of a process, or `machine`; the injection) of `robot_1 slow 4 for 5 s`; FieldError.

    The name may be a pattern.
    """
    name, _, what = line.strip().partition(" ") if isinstance(line, str) else ("", "", "")
    if not what.strip():
        raise FieldError(f"invalid injection {line!r}", hint=f"as in '{EXAMPLE}'")
    injection = parsed(what)
    if name == MACHINE:
        refuse_machine(injection)
    return name, injection


def refuse_machine(injection: Injection) -> None:
    """FieldError if it needs a process."""
    if not injection.on_machine:
        known = ", ".join(kind.name for kind in _KINDS if kind.on_machine)
        raise FieldError(f"{injection.kind} is about a process", hint=f"of the machine: {known}")


def lasting(injection: Injection, for_s: float) -> Injection:
    """The same for another time, if it lasts at all."""
    return injection if injection.for_s is None else replace(injection, for_s=for_s)


def patterns(names: str = r"\S+") -> Iterable[tuple[str, str]]:
    """For JSON Schemas: (the expression, an example) of each kind of line."""
    for kind in _KINDS:
        words = "".join(
            f" +(?:{one.pattern})" if one.is_needed else f"(?: +(?:{one.pattern}))?"
            for one in kind.arguments
        )
        time = rf"(?: +for +(?:{DURATION_PATTERN}))?" if kind.lasts else ""
        yield for_editors(f"{names} +{kind.name}{words}{time}"), kind.example
