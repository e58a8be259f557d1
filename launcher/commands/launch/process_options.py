"""Options about single processes: how they are stopped, and their limits.

Each is read from a word `PATTERN=...` (or `PATTERN:...`), and is imported when it is used.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
from collections.abc import Callable
from pathlib import Path

from launcher.command_line import seconds
from launcher.commands.launch.options import for_pattern, parse_restart
from launcher.errors import UsageError
from launcher.model.spec import UNLIMITED, Limits, StopPolicy

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_DEFAULT_WAIT_S = 5.0  # as in ROS 2
_UNITS = {"": 1, "K": 1024, "M": 1024**2, "G": 1024**3}


@for_pattern("=", "--stop 'robot_*=int:2,term:1'")
def parse_stop(text: str) -> StopPolicy:
    """`SIGNAL[:S],SIGNAL[:S],...`: the signals, and how many seconds to wait after each."""
    polite: list[tuple[signal.Signals, float]] = []
    *steps, last = text.split(",")
    for step in (*steps, last):
        name, _, time = step.partition(":")
        signum = _signal(name)
        if signum == signal.SIGKILL:
            if time or step is not last:
                raise ValueError("kill comes last and waits for nothing")
            break
        polite.append((signum, seconds(time) if time else _DEFAULT_WAIT_S))
    return StopPolicy(polite=tuple(polite))


def _signal(name: str) -> signal.Signals:
    full = name.strip().upper()
    full = full if full.startswith("SIG") else f"SIG{full}"
    if full not in signal.Signals.__members__:
        known = "int, term, quit, hup, usr1, kill"
        raise ValueError(f"unknown signal '{name}'; there are {known} and more")
    return signal.Signals[full]


@for_pattern("=", "--nice 'robot_*=5'")
def parse_nice(text: str) -> Limits:
    """A niceness from -20 (highest priority) to 19."""
    try:
        nice = int(text)
    except ValueError:
        nice = 99
    if not -20 <= nice <= 19:
        raise ValueError("a niceness is a whole number from -20 to 19")
    return Limits(nice=nice)


@for_pattern("=", "--cpus 'robot_*=0,2-3'")
def parse_cpus(text: str) -> Limits:
    """The processors that it may run on, as in `0,2-3`."""
    cpus: set[int] = set()
    for part in text.split(","):
        first, _, last = part.partition("-")
        try:
            found = range(int(first), int(last or first) + 1)
        except ValueError:
            found = range(0)
        if not found:
            raise ValueError(f"'{part}' is not a processor or a range of them")
        cpus.update(found[:MOST_CPUS])
    count = os.cpu_count() or MOST_CPUS
    if max(cpus) >= count:
        raise ValueError(f"there are processors 0 to {count - 1}")
    return Limits(cpus=tuple(sorted(cpus)))


MOST_CPUS = 8192  # what the kernel can be built for


@for_pattern(":", "--limit 'robot_*:nofile=256,as=1G,core=0'")
def parse_limit(text: str, *, most_granted: Callable[[str], int] | None = None) -> Limits:
    """`NAME=VALUE,...`; VALUE is a number with K, M, G or `unlimited`, or SOFT/HARD.

    More than `most_granted` of a name returns is refused.
    """
    rlimits: dict[str, tuple[str, int, int]] = {}
    for part in text.split(","):
        name, _, value = part.partition("=")
        if name not in limit_names():
            known = ", ".join(limit_names())
            raise ValueError(f"there is no limit '{name}'; there are {known}")
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


def settings_of(path: str) -> list[tuple[str, Any]]:
    """What a YAML file says, as pairs of a field of RunOptions and a value for it; UsageError."""
    from launcher.engine.monitor.budget_parser import names_in, settings_in, text_of

    text = text_of(path)
    found: list[tuple[str, Any]] = [("budget_files", (path, text))]
    found += [("file_names", name) for name in names_in(text, path)]
    for setting in settings_in(text, path):
        mark = ":" if setting.key == "limit" else "="
        field, parse = _SETTINGS[setting.key]
        try:
            found.append((field, parse(f"{setting.pattern}{mark}{setting.value}")))
        except UsageError as error:
            raise setting.place.error(error.message, error.hint) from None
    return found


_SETTINGS: dict[str, tuple[str, Callable[[str], Any]]] = {
    "restart": ("restart", parse_restart),
    "stop": ("stop", parse_stop),
    "nice": ("limits", parse_nice),
    "cpus": ("limits", parse_cpus),
    "limit": ("limits", parse_limit),
}
