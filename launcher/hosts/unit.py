"""Units of systemd for processes: names, settings from our policies, quoting, environment files.

The one home of these: transient units of a run and exported unit files are made of the same
settings. Nothing here starts anything. Systemd 249 to 257 are supported; `Setting.since` is the
version that a setting needs.
"""

from __future__ import annotations

import hashlib
import math
import os
import re
import string
from collections.abc import Iterable, Iterator, Mapping, Sequence

from launcher.base.model.record import Record
from launcher.base.model.spec import UNLIMITED, Limits, RestartMode, RestartPolicy, StopPolicy

OLDEST = 249  # the oldest version that is supported
# Characters of a unit's name with its suffix. Systemd allows 255, but the journal loses all output
# of a unit with so many, and files beside its own (`NAME.service.new`) need some more.
MAX_NAME = 230
_LAUNCH_FILE = (".launch.py", ".launch.xml", ".launch.yaml", ".launch.yml", ".py", ".xml", ".yaml")
_IN_NAMES = frozenset(string.ascii_letters + string.digits + ":_.")
_VARIABLE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
# Signals after which systemd takes an exit for a success, and does not restart on failure.
_CLEAN_SIGNALS = "SIGHUP SIGINT SIGTERM SIGPIPE"


class UnitSetting(Record):
    """`key=value` in a section of a unit, and the version of systemd that it needs."""

    key: str
    value: str
    section: str = "Service"
    since: int = OLDEST

    def __str__(self) -> str:
        return f"{self.key}={self.value}"


# ---- names


def unit_name(*parts: str, suffix: str = "service") -> str:
    """`launcher-PART-PART.service`; other characters than systemd allows are escaped as `\\x40`.

    A dash within a part stays; a name that is too long ends in a digest of it.
    """
    stem = "-".join(["launcher", *(_escaped(part, dash=True) for part in parts)])
    return _shortened(stem, suffix)


def installed_name(path: str) -> str:
    """Of what `--enable` installs for a launch file: `launcher-system`."""
    return f"launcher-{stem_of(path)}"


def stem_of(path: str) -> str:
    """`system` for `launch/system.launch.py`."""
    name = os.path.basename(path)
    suffix = next((one for one in _LAUNCH_FILE if name.endswith(one)), "")
    return name.removesuffix(suffix) or "system"


def slice_name(*parts: str) -> str:
    """`launcher_PART.slice`; a dash within a part is escaped.

    It is in no slice of ours: that could never be stopped safely, as another run may just start.
    """
    stem = "_".join(["launcher", *(_escaped(part, dash=False) for part in parts)])
    return _shortened(stem, "slice")


def _escaped(part: str, *, dash: bool) -> str:
    allowed = _IN_NAMES | {"-"} if dash else _IN_NAMES
    return "".join(
        char if char in allowed else "".join(f"\\x{byte:02x}" for byte in _bytes(char))
        for char in part
    )


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")


def _shortened(stem: str, suffix: str) -> str:
    most = MAX_NAME - len(suffix) - 1
    if len(stem) > most:
        digest = hashlib.sha256(_bytes(stem)).hexdigest()[:12]
        stem = f"{stem[: most - 13].rstrip(chr(92))}_{digest}"
    return f"{stem}.{suffix}"


# ---- settings


def process_settings(
    restart: RestartPolicy, stop: StopPolicy, limits: Limits | None
) -> tuple[UnitSetting, ...]:
    """The settings of a process's unit that follow from its policies, in a fixed order."""
    return (
        *restart_settings(restart),
        *stop_settings(stop),
        *limit_settings(limits),
        *output_settings(),
        UnitSetting("IgnoreSIGPIPE", "no"),  # as without systemd
    )


def restart_settings(policy: RestartPolicy) -> Iterator[UnitSetting]:
    """`Restart=` and the limits of restarts.

    Systemd has no random delay and no reset of a growing delay after a quiet time; its limit within
    a window counts the first start, too (see `unmet`).
    """
    if policy.mode is RestartMode.NEVER or policy.max_restarts == 0:
        yield UnitSetting("Restart", "no")
        return
    yield UnitSetting("Restart", policy.mode.value)
    if policy.mode is RestartMode.ON_FAILURE:
        yield UnitSetting("RestartForceExitStatus", _CLEAN_SIGNALS)
    yield UnitSetting("RestartSec", seconds(policy.delay_s))
    yield from _growing_delay(policy)
    if policy.max_restarts is None:
        yield UnitSetting("StartLimitIntervalSec", "0", "Unit")
        return
    interval = "infinity" if policy.window_s is None else seconds(max(policy.window_s, 1e-3))
    yield UnitSetting("StartLimitIntervalSec", interval, "Unit")
    yield UnitSetting("StartLimitBurst", str(policy.max_restarts + 1), "Unit")


def _growing_delay(policy: RestartPolicy) -> Iterator[UnitSetting]:
    most = policy.backoff_max_s
    if most is None or policy.delay_s <= 0 or most <= policy.delay_s:
        return
    steps = max(1, math.ceil(math.log2(most / policy.delay_s) - 1e-9))
    yield UnitSetting("RestartSteps", str(steps), since=254)
    yield UnitSetting("RestartMaxDelaySec", seconds(most), since=254)


def stop_settings(policy: StopPolicy) -> Iterator[UnitSetting]:
    """The first signal, and SIGKILL after the whole grace; systemd has none in between."""
    yield UnitSetting("KillMode", "control-group")
    yield UnitSetting("KillSignal", policy.steps[0][0].name)
    yield UnitSetting("TimeoutStopSec", seconds(max(policy.grace_s, 1e-3)))  # 0 would mean for ever
    yield UnitSetting("SendSIGKILL", "yes")


def limit_settings(limits: Limits | None) -> Iterator[UnitSetting]:
    if limits is None:
        return
    if limits.nice is not None:
        yield UnitSetting("Nice", str(limits.nice))
    if limits.cpus is not None:
        yield UnitSetting("CPUAffinity", " ".join(map(str, limits.cpus)))
    for name, soft, hard in limits.rlimits:
        yield UnitSetting(f"Limit{name.upper()}", f"{_amount(soft)}:{_amount(hard)}")


def _amount(amount: int) -> str:
    return "infinity" if amount == UNLIMITED else str(amount)


def output_settings() -> Iterator[UnitSetting]:
    """Every line goes to the journal as it is, however many there are.

    Systemd (252 at least) does not pass an interval of 0 to the journal, so the limit is one that
    nothing reaches. For units of a user's manager it has no effect.
    """
    yield UnitSetting("StandardOutput", "journal")
    yield UnitSetting("StandardError", "journal")
    yield UnitSetting("SyslogLevelPrefix", "no")
    yield UnitSetting("LogRateLimitIntervalSec", "1ms")
    yield UnitSetting("LogRateLimitBurst", "1000000")


def seconds(amount_s: float) -> str:
    """A time as systemd reads it: `5s`, `1500ms`, `infinity`."""
    if math.isinf(amount_s):
        return "infinity"
    amount_ms = round(amount_s * 1000)
    return f"{amount_ms}ms" if amount_ms % 1000 else f"{amount_ms // 1000}s"


def supported(
    settings: Iterable[UnitSetting], version: int
) -> tuple[tuple[UnitSetting, ...], tuple[UnitSetting, ...]]:
    """(the settings that this version of systemd supports, those that it does not)."""
    every = tuple(settings)
    known = tuple(one for one in every if one.since <= version)
    return known, tuple(one for one in every if one.since > version)


def unmet(restart: RestartPolicy, stop: StopPolicy, version: int) -> Iterator[str]:
    """What systemd does otherwise than the launcher, one phrase each, for messages."""
    _, unknown = supported(restart_settings(restart), version)
    for one in unknown:
        if one.key == "RestartSteps":
            yield f"its restart delay does not grow (needs systemd {one.since}, has {version})"
    if restart.mode is not RestartMode.NEVER and restart.jitter:
        yield "its restart delay has no random part"
    polite = stop.steps[1:-1]
    if polite:
        names = " and ".join(signum.name for signum, _ in polite)
        yield f"{names} is left out when systemd stops it by itself"


# ---- quoting


def exec_line(words: Sequence[str]) -> str:
    """The words as the value of `ExecStart=`, so that systemd passes on exactly these."""
    return " ".join(_quoted_word(word, is_program=not index) for index, word in enumerate(words))


_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r", "%": "%%"}
_PLAIN_WORD = re.compile(r"[A-Za-z0-9_./:=,+@^-]+\Z")


def _quoted_word(word: str, *, is_program: bool) -> str:
    if _PLAIN_WORD.match(word) and not (is_program and word[0] in "@-:+!"):
        return word
    escapes = _ESCAPES if is_program else {**_ESCAPES, "$": "$$"}
    return '"' + "".join(_escaped_char(char, escapes) for char in word) + '"'


def _escaped_char(char: str, escapes: Mapping[str, str]) -> str:
    if char in escapes:
        return escapes[char]
    if char.isprintable():
        return char
    return "".join(f"\\x{byte:02x}" for byte in _bytes(char))


def literal(value: str) -> str:
    """A value (a path, a description) in which `%` has no meaning, on one line."""
    return " ".join(value.split("\n")).replace("%", "%%")


def environment_file(environment: Mapping[str, str]) -> str:
    """The content of a file for `EnvironmentFile=`, which a POSIX shell can source, too.

    ValueError names a variable that such a file cannot hold, see `fits_environment_file`; the
    message has no value.
    """
    lines = []
    for name, value in sorted(environment.items()):
        if not fits_environment_file(name, value):
            raise ValueError(f"the variable {name!r} does not fit into an environment file")
        lines.append(f'{name}="{_ENVIRONMENT.sub(_backslashed, value)}"\n')
    return "".join(lines)


_ENVIRONMENT = re.compile(r'["\\`$]')


def _backslashed(found: re.Match[str]) -> str:
    return f"\\{found[0]}"


def is_variable(name: str) -> bool:
    """Whether shells and systemd take it for the name of a variable."""
    return _VARIABLE.match(name) is not None


def fits_environment_file(name: str, value: str) -> bool:
    """Whether systemd takes the variable: a plain name, and UTF-8 without control characters."""
    return is_variable(name) and not any(
        (char < " " and char not in "\n\t") or char == "\x7f" or "\ud800" <= char <= "\udfff"
        for char in value
    )
