"""Options about single processes: how they are stopped, and what the system grants them.

Each is read from a word `PATTERN=...` (or `PATTERN:...`), and is imported when it is used.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
from collections.abc import Callable
from pathlib import Path

from launcher.commands.launch.options import parse_restart, seconds
from launcher.errors import UsageError
from launcher.model.limits import UNLIMITED, Limits
from launcher.model.options import RunOptions
from launcher.model.record import replace
from launcher.model.spec import StopPolicy

_STOP_EXAMPLE = "for example: --stop 'robot_*=int:2,term:1'"
_NICE_EXAMPLE = "for example: --nice 'robot_*=5'"
_CPUS_EXAMPLE = "for example: --cpus 'robot_*=0,2-3'"
_LIMIT_EXAMPLE = "for example: --limit 'robot_*:nofile=256,as=1G,core=0'"
_DEFAULT_WAIT_S = 5.0  # as in ROS 2
_UNITS = {"": 1, "K": 1024, "M": 1024**2, "G": 1024**3}


def parse_stop(word: str) -> tuple[str, StopPolicy]:
    """`PATTERN=SIGNAL[:S],SIGNAL[:S],...`: what is sent, and how long it may take; UsageError."""
    pattern, text = _split(word, "=", _STOP_EXAMPLE)
    polite: list[tuple[signal.Signals, float]] = []
    *steps, last = text.split(",")
    for step in (*steps, last):
        name, _, time = step.partition(":")
        signum = _signal(name, word)
        if signum == signal.SIGKILL:
            if time or step is not last:
                raise _wrong(word, "kill comes last and waits for nothing", _STOP_EXAMPLE)
            break
        polite.append((signum, _wait_s(time, word)))
    return pattern, StopPolicy(polite=tuple(polite))


def _signal(name: str, word: str) -> signal.Signals:
    full = name.strip().upper()
    full = full if full.startswith("SIG") else f"SIG{full}"
    if full not in signal.Signals.__members__:
        known = "int, term, quit, hup, usr1, kill"
        raise _wrong(word, f"there is no signal '{name}', but {known} and more", _STOP_EXAMPLE)
    return signal.Signals[full]


def _wait_s(text: str, word: str) -> float:
    try:
        return seconds(text) if text else _DEFAULT_WAIT_S
    except ValueError:
        raise _wrong(word, f"'{text}' is no number of seconds", _STOP_EXAMPLE) from None


def parse_nice(word: str) -> tuple[str, Limits]:
    """`PATTERN=N` with N from -20 (first) to 19 (last); UsageError."""
    pattern, text = _split(word, "=", _NICE_EXAMPLE)
    try:
        nice = int(text)
    except ValueError:
        nice = 99
    if not -20 <= nice <= 19:
        raise _wrong(word, "a niceness is a whole number from -20 to 19", _NICE_EXAMPLE)
    return pattern, Limits(nice=nice)


def parse_cpus(word: str) -> tuple[str, Limits]:
    """`PATTERN=0,2-3`: the processors that it may run on; UsageError."""
    pattern, text = _split(word, "=", _CPUS_EXAMPLE)
    cpus: set[int] = set()
    for part in text.split(","):
        first, _, last = part.partition("-")
        try:
            found = range(int(first), int(last or first) + 1)
        except ValueError:
            found = range(0)
        if not found:
            raise _wrong(word, f"'{part}' is no processor and no range", _CPUS_EXAMPLE)
        cpus.update(found[:MOST_CPUS])
    count = os.cpu_count() or MOST_CPUS
    if max(cpus) >= count:
        raise _wrong(word, f"there are processors 0 to {count - 1}", _CPUS_EXAMPLE)
    return pattern, Limits(cpus=tuple(sorted(cpus)))


MOST_CPUS = 8192  # what the kernel can be built for


def parse_limit(
    word: str, *, most_granted: Callable[[str], int] | None = None
) -> tuple[str, Limits]:
    """`PATTERN:NAME=VALUE,...`; VALUE is a number with K, M, G or `unlimited`, or SOFT/HARD.

    UsageError also for what is more than `most_granted` of a name says.
    """
    pattern, text = _split(word, ":", _LIMIT_EXAMPLE)
    rlimits: dict[str, tuple[str, int, int]] = {}
    for part in text.split(","):
        name, _, value = part.partition("=")
        if name not in limit_names():
            known = ", ".join(limit_names())
            raise _wrong(word, f"there is no limit '{name}', only {known}", _LIMIT_EXAMPLE)
        soft, slash, hard = value.partition("/")
        limits = _amount(soft, word), _amount(hard if slash else soft, word)
        if limits[1] != UNLIMITED and not 0 <= limits[0] <= limits[1]:
            raise _wrong(word, f"in '{part}' the soft limit is above the hard one", _LIMIT_EXAMPLE)
        most = (most_granted or _most_granted)(name)
        if most != UNLIMITED and (limits[1] == UNLIMITED or limits[1] > most):
            problem = f"'{part}' is more than is allowed here: the hard limit is {most}"
            raise _wrong(word, problem, _LIMIT_EXAMPLE)
        rlimits[name] = (name, *limits)
    return pattern, Limits(rlimits=tuple(rlimits.values()))


def _most_granted(name: str) -> int:
    """What a process of ours may have at most: our own hard limit, unless we may raise it."""
    own = resource.getrlimit(getattr(resource, f"RLIMIT_{name.upper()}"))[1]
    with contextlib.suppress(OSError, ValueError):
        if name == "nofile":  # nobody gets more, whoever asks
            own = int(Path("/proc/sys/fs/nr_open").read_text()) if _may_raise() else own
        elif _may_raise():
            own = UNLIMITED
    return own


_CAP_SYS_RESOURCE = 24


def _may_raise() -> bool:
    """Whether the kernel lets us raise hard limits; OSError or ValueError if it does not tell."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("CapEff:"):
            return bool(int(line.split()[1], 16) >> _CAP_SYS_RESOURCE & 1)
    return False


def limit_names() -> list[str]:
    """The names of what can be limited, as in `ulimit` and limits.conf: `nofile`, `as`, `core`."""
    return sorted(name[7:].lower() for name in dir(resource) if name.startswith("RLIMIT_"))


def _amount(text: str, word: str) -> int:
    if text == "unlimited":
        return UNLIMITED
    number, unit = (text[:-1], text[-1:].upper()) if text[-1:].isalpha() else (text, "")
    if unit not in _UNITS or not number.isascii() or not number.isdigit():
        raise _wrong(word, f"'{text}' is no number, as 256, 1G or unlimited are", _LIMIT_EXAMPLE)
    amount = int(number) * _UNITS[unit]
    if amount >= 1 << 63:
        raise _wrong(word, f"'{text}' is more than there is", _LIMIT_EXAMPLE)
    return amount


def with_file(options: RunOptions, path: str) -> RunOptions:
    """The options with the text of a YAML file, the names and the settings in it; UsageError."""
    from launcher.engine.budget_reader import names_in, settings_in, text_of

    text = text_of(path)
    options = replace(
        options,
        budget_files=(*options.budget_files, (path, text)),
        file_names=(*options.file_names, *names_in(text, path)),
    )
    for setting in settings_in(text, path):
        mark = ":" if setting.key == "limit" else "="
        word = f"{setting.pattern}{mark}{setting.value}"
        try:
            options = _with_setting(options, setting.key, word)
        except UsageError as error:
            raise setting.place.error(error.message, error.hint) from None
    return options


def _with_setting(options: RunOptions, key: str, word: str) -> RunOptions:
    if key == "restart":
        return replace(options, restart=(*options.restart, parse_restart(word)))
    if key == "stop":
        return replace(options, stop=(*options.stop, parse_stop(word)))
    parse = {"nice": parse_nice, "cpus": parse_cpus, "limit": parse_limit}[key]
    return replace(options, limits=(*options.limits, parse(word)))


def _split(word: str, mark: str, example: str) -> tuple[str, str]:
    pattern, _, text = word.partition(mark)
    if not pattern or not text:
        raise UsageError(f"'{word}' is not NAME{mark}...", hint=example)
    return pattern, text


def _wrong(word: str, problem: str, example: str) -> UsageError:
    return UsageError(f"in '{word}': {problem}", hint=example)
