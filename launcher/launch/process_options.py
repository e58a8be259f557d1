"""Parsers of options about single processes: restart, stop signals and limits.

The value of such an option is a word `PATTERN=...` (or `PATTERN:...`).
"""

from __future__ import annotations

import functools
import os
import re
import resource
import signal
from collections.abc import Callable, Sequence

from launcher.base.errors import UsageError
from launcher.base.model.record import replace
from launcher.base.model.spec import (
    UNLIMITED,
    Limits,
    RestartMode,
    RestartPolicy,
    StopPolicy,
)
from launcher.base.option import count, seconds
from launcher.base.text import did_you_mean
from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_BACKOFF_JITTER = 0.1
_DEFAULT_WAIT_S = 5.0  # as in ROS 2
_UNITS = {"": 1, "K": 1024, "M": 1024**2, "G": 1024**3}


def for_pattern(mark: str, example: str) -> Callable[[Callable[[str], Any]], Callable[[str], Any]]:
    """Decorator: from a parser of `...` to one of `PATTERN=...`, which returns a pair.

    ValueErrors become UsageErrors with the whole word and an example.
    """

    def decorate(parse: Callable[..., Any]) -> Callable[..., tuple[str, Any]]:
        @functools.wraps(parse)
        def read(word: str, **more: object) -> tuple[str, Any]:
            pattern, _, text = word.partition(mark)
            try:
                if not pattern or not text:
                    raise ValueError(f"expected NAME{mark}...")
                return pattern, parse(text, **more)
            except ValueError as error:
                hint = f"for example: {example}"
                raise UsageError(f"in '{word}': {error}", hint=hint) from None

        return read

    return decorate


def restart_policy(text: str) -> RestartPolicy:
    """`MODE[,max=N][,window=S][,backoff=A..B][,delay=S][,quiet=S]`."""
    mode, *settings = text.split(",")
    modes = {one.value: one for one in RestartMode}
    if mode not in modes:
        raise ValueError(f"the mode is one of {', '.join(modes)}")
    policy = RestartPolicy(mode=modes[mode])
    given: list[str] = []
    for setting in settings:
        name, _, value = setting.partition("=")
        if name not in _RESTART_SETTINGS:
            raise ValueError(f"unknown setting '{name}'; known: {', '.join(_RESTART_SETTINGS)}")
        if name in given:
            raise ValueError(f"'{name}' is given twice")
        try:
            policy = _RESTART_SETTINGS[name](policy, value)
        except ValueError:
            meant = _MEANT.get(name, "a number of seconds")
            raise ValueError(f"'{setting}' is not {meant}") from None
        given.append(name)
    if "delay" in given and "backoff" in given:
        raise ValueError("'delay' and 'backoff' exclude each other")
    return policy


_MEANT = {
    "max": "a whole number, 0 or more",
    "backoff": "two numbers of seconds, the second not below the first, as in 0.5..30",
}


def _backoff(policy: RestartPolicy, text: str) -> RestartPolicy:
    first, _, most = text.partition("..")
    first_s, most_s = seconds(first), seconds(most)
    if most_s < first_s:
        raise ValueError(text)
    return replace(policy, delay_s=first_s, backoff_max_s=most_s, jitter=_BACKOFF_JITTER)


_RESTART_SETTINGS: dict[str, Callable[[RestartPolicy, str], RestartPolicy]] = {
    "max": lambda policy, text: replace(policy, max_restarts=count(text)),
    "window": lambda policy, text: replace(policy, window_s=seconds(text)),
    "backoff": _backoff,
    "delay": lambda policy, text: replace(policy, delay_s=seconds(text)),
    "quiet": lambda policy, text: replace(policy, quiet_s=seconds(text)),
}


def stop_policy(text: str) -> StopPolicy:
    """`SIGNAL[:S],SIGNAL[:S],...`: the signals, and how many seconds to wait after each."""
    polite: list[tuple[signal.Signals, float]] = []
    *steps, last = text.split(",")
    for step in (*steps, last):
        name, _, time = step.partition(":")
        signum = _signal(name)
        if signum == signal.SIGKILL:
            if time or step is not last:
                raise ValueError("kill must be the last signal, without a time")
            break
        polite.append((signum, seconds(time) if time else _DEFAULT_WAIT_S))
    return StopPolicy(polite=tuple(polite))


def _signal(name: str) -> signal.Signals:
    full = name.strip().upper()
    full = full if full.startswith("SIG") else f"SIG{full}"
    if full not in signal.Signals.__members__:
        known = "int, term, quit, hup, usr1, kill"
        raise ValueError(f"unknown signal '{name}'; known: {known} and more")
    return signal.Signals[full]


def niceness(text: str) -> Limits:
    """A niceness from -20 (highest priority) to 19."""
    try:
        nice = int(text)
    except ValueError:
        nice = 99
    if not -20 <= nice <= 19:
        raise ValueError("a niceness is a whole number from -20 to 19")
    return Limits(nice=nice)


def processors(text: str, *, is_here: bool = True) -> Limits:
    """The processors that it may run on, as in `0,2-3`; with `is_here`, only those there are."""
    cpus: set[int] = set()
    for part in text.split(","):
        first, _, last = part.partition("-")
        try:
            found = range(int(first), int(last or first) + 1)
        except ValueError:
            found = range(0)
        if not found:
            raise ValueError(f"'{part}' is not a processor or a range of them")
        cpus.update(found[:MAX_CPUS])
    number = (is_here and os.cpu_count()) or MAX_CPUS
    if max(cpus) >= number:
        raise ValueError(f"this machine has processors 0 to {number - 1}")
    return Limits(cpus=tuple(sorted(cpus)))


MAX_CPUS = 8192  # what the kernel can be built for


def resource_limits(text: str, *, most_granted: Callable[[str], int] | None = None) -> Limits:
    """`NAME=VALUE,...`; VALUE is a number with K, M, G or `unlimited`, or SOFT/HARD.

    More than `most_granted` of a name returns is refused.
    """
    rlimits: dict[str, tuple[str, int, int]] = {}
    for part in text.split(","):
        name, _, value = part.partition("=")
        if name not in limit_names():
            known = ", ".join(limit_names())
            raise ValueError(f"unknown limit '{name}'; known: {known}")
        soft, slash, hard = value.partition("/")
        limits = _amount(soft), _amount(hard if slash else soft)
        if limits[1] != UNLIMITED and not 0 <= limits[0] <= limits[1]:
            raise ValueError(f"in '{part}' the soft limit is above the hard one")
        most = (most_granted or _most_granted)(name)
        if most != UNLIMITED and (limits[1] == UNLIMITED or limits[1] > most):
            problem = f"'{part}' is more than is allowed here: the hard limit is {most}"
            raise ValueError(problem)
        rlimits[name] = (name, *limits)
    return Limits(rlimits=tuple(rlimits.values()))


def _most_granted(name: str) -> int:
    """The highest hard limit that a child may get: ours, unless we may raise it."""
    own = resource.getrlimit(getattr(resource, f"RLIMIT_{name.upper()}"))[1]
    if not _may_raise():
        return own
    if name != "nofile":
        return UNLIMITED
    most = proc.read("sys", "fs/nr_open")  # holds for every process, privileged or not
    return int(most) if most else own


_CAP_SYS_RESOURCE = 24


def _may_raise() -> bool:
    """Whether the kernel lets us raise hard limits."""
    return bool(int(proc.status_field("self", "CapEff") or "0", 16) >> _CAP_SYS_RESOURCE & 1)


def limit_names() -> list[str]:
    """The names of what can be limited, as in `ulimit` and limits.conf: `nofile`, `as`, `core`."""
    return sorted(name[7:].lower() for name in dir(resource) if name.startswith("RLIMIT_"))


def _amount(text: str) -> int:
    if text == "unlimited":
        return UNLIMITED
    number, unit = (text[:-1], text[-1:].upper()) if text[-1:].isalpha() else (text, "")
    if unit not in _UNITS or not number.isascii() or not number.isdigit():
        raise ValueError(f"'{text}' is not a number such as 256, 1G or unlimited")
    amount = int(number) * _UNITS[unit]
    if amount >= 1 << 63:
        raise ValueError(f"'{text}' is too large")
    return amount


@for_pattern("=", "--prefix 'robot_1=gdb -ex run --args python3'")
def parse_prefix(text: str) -> tuple[str, ...]:
    """Words as in a shell, with its quotes."""
    import shlex

    try:
        words = shlex.split(text)
    except ValueError as error:
        raise ValueError(f"{str(error).lower()} in {text!r}") from None
    if not words or not words[0]:
        raise ValueError("there are no words to put in front of the command")
    return tuple(words)


def refuse_absent_programs(prefixes: Sequence[tuple[str, Sequence[str]]]) -> None:
    """UsageError for words in front of a command whose first is no program of this machine."""
    import shutil

    for pattern, words in prefixes:
        if shutil.which(words[0]) is None:
            problem = f"in --prefix '{pattern}={' '.join(words)}': there is no program '{words[0]}'"
            raise UsageError(problem, hint="is it installed, and in the PATH?")


_LEVELS = ("debug", "info", "warn", "error", "fatal")
_LOGGER = re.compile(r"[^\s:=,]+")


def parse_log_levels(word: str) -> list[tuple[str, Any]]:
    """(field of RunOptions, (pattern, (logger or nothing, level))) for each part of the word."""
    return [("log_levels", _log_level(part)) for part in word.split(",")]


def _log_level(part: str) -> tuple[str, tuple[str, str]]:
    name, _, level = part.rpartition("=")
    pattern, colon, logger = name.partition(":")
    lower = level.lower()
    lower = "warn" if lower == "warning" else lower  # which rcl does not take
    if not pattern:
        hint = f"for all processes: --log-level '*={lower}'" if lower in _LEVELS else _EXAMPLE
        raise UsageError(f"in '{part}': expected NAME=LEVEL", hint=hint)
    if colon and not _LOGGER.fullmatch(logger):
        raise UsageError(f"in '{part}': '{logger}' is not the name of a logger", hint=_EXAMPLE)
    if lower not in _LEVELS:
        hint = did_you_mean(lower, _LEVELS) or f"known: {', '.join(_LEVELS)}"
        raise UsageError(f"in '{part}': unknown level '{level}'", hint=hint)
    return pattern, (logger, lower)


_EXAMPLE = "for example: --log-level 'robot_1=debug,*=warn' or 'robot_1:rcl=debug'"


parse_restart = for_pattern("=", "--restart robot_2=on-failure,max=5,window=60,backoff=0.5..30")(
    restart_policy
)
parse_stop = for_pattern("=", "--stop 'robot_*=int:2,term:1'")(stop_policy)
parse_nice = for_pattern("=", "--nice 'robot_*=5'")(niceness)
parse_cpus = for_pattern("=", "--cpus 'robot_*=0'")(processors)
parse_limit = for_pattern(":", "--limit 'robot_*:nofile=256,as=1G,core=0'")(resource_limits)
