"""A wheelhouse: which of its wheels a host can use, and how it is filled for one."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launcher.base.errors import LauncherError, UsageError
from launcher.base.model.record import Record
from launcher.base.text import count
from launcher.hosts.sync.on_host import pip_messages
from launcher.hosts.sync.pinned_list import Pin, names, packaging

_OLDEST_MINOR = {"x86_64": 5, "i686": 5}  # of glibc 2, for which manylinux has a name
_LEGACY = {17: "manylinux2014", 12: "manylinux2010", 5: "manylinux1"}
_MOST_SOURCES = 8  # packages without a wheel for which pip is asked again
_filling = threading.Lock()
_is_offline = False  # once it is known, no other host has to wait for it


class PythonTarget(Record):
    """The Python of a host; `glibc` is None with another C library."""

    version: tuple[int, int]
    machine: str
    glibc: tuple[int, int] | None
    markers: Mapping[str, str]

    def __str__(self) -> str:
        libc = "no glibc" if self.glibc is None else f"glibc {self.glibc[0]}.{self.glibc[1]}"
        return f"Python {self.version[0]}.{self.version[1]}, {self.machine}, {libc}"

    @property
    def platforms(self) -> list[str]:
        """Platforms of wheels that it can use, the newest first."""
        if self.glibc is None:
            return [f"linux_{self.machine}"]
        found = []
        for minor in range(self.glibc[1], _OLDEST_MINOR.get(self.machine, 17) - 1, -1):
            found.append(f"manylinux_2_{minor}_{self.machine}")
            if minor in _LEGACY:
                found.append(f"{_LEGACY[minor]}_{self.machine}")
        return [*found, f"linux_{self.machine}"]


def target_of(facts: Mapping[str, Any]) -> PythonTarget:
    """The target that a host's answer describes."""
    libc = facts["libc"]
    glibc = None
    if libc[:1] == ["glibc"]:
        major, minor = libc[1].split(".")[:2]
        glibc = (int(major), int(minor))
    version = (int(facts["version"][0]), int(facts["version"][1]))
    return PythonTarget(
        version=version, machine=facts["machine"], glibc=glibc, markers=facts["markers"]
    )


class WheelChoice(Record):
    """The wheels of a folder that a host needs, and what the folder lacks."""

    files: tuple[str, ...] = ()
    missing: tuple[Pin, ...] = ()


def present(folder: str, pins: Sequence[Pin], target: PythonTarget) -> WheelChoice:
    """What is there already; nothing is downloaded."""
    if not os.path.isdir(folder):
        return WheelChoice(missing=tuple(pins))
    found = {pin: _best(folder, pin, target) for pin in pins}
    return WheelChoice(
        files=tuple(file for file in found.values() if file is not None),
        missing=tuple(pin for pin, file in found.items() if file is None),
    )


def chosen(
    folder: str,
    pins: Sequence[Pin],
    target: PythonTarget,
    say: Callable[[str], None] = lambda _: None,
) -> list[str]:
    """The file of each pin, after what is missing was downloaded; LauncherError."""
    problem = ""
    with _filling:
        _require_folder(folder)
        found = present(folder, pins, target)
        if found.missing:
            say(f"downloads {count(len(found.missing), 'wheel')} for {target} into {folder}")
            problem = _download(folder, found.missing, target)
            found = present(folder, pins, target)
    if found.missing:
        others = [file for file in _wheels(folder) if _is_of(file, found.missing[0])]
        has = f"; of it there is only {others[0]}" if others else ""
        raise LauncherError(
            f"{folder} has no wheel of {names(found.missing)} for {target}{has}",
            hint=pip_messages.advice(problem) or (problem and f"pip download failed: {problem}"),
        )
    return [*found.files]


def _require_folder(folder: str) -> None:
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise UsageError(f"--wheelhouse: {folder}: {error.strerror}") from None


def _wheels(folder: str) -> list[str]:
    return sorted(name for name in os.listdir(folder) if name.endswith(".whl"))


def _is_of(file: str, pin: Pin) -> bool:
    utils, version = packaging("utils"), packaging("version")
    name, _, rest = file.partition("-")
    if utils.canonicalize_name(name).replace("-", "_") != pin.name:
        return False
    try:
        found = version.Version(rest.partition("-")[0])
        wanted = version.Version(pin.version)
    except version.InvalidVersion:
        return False
    return bool(found == wanted or found.public == pin.version)


def _best(folder: str, pin: Pin, target: PythonTarget) -> str | None:
    """The wheel for the newest platform that the target can use."""
    tags = packaging("tags")
    supported = {tag: place for place, tag in enumerate(supported_tags(target))}
    found: list[tuple[int, str]] = []
    for file in _wheels(folder):
        if _is_of(file, pin):
            own = tags.parse_tag("-".join(file[:-4].split("-")[-3:]))
            places = [supported[tag] for tag in own if tag in supported]
            if places and _has_hash(os.path.join(folder, file), pin):
                found.append((min(places), file))
    return min(found)[1] if found else None


def supported_tags(target: PythonTarget) -> list[Any]:
    """The tags of wheels that a target can use, the best first."""
    tags = packaging("tags")
    interpreter = f"cp{target.version[0]}{target.version[1]}"
    own = tags.cpython_tags(target.version, [interpreter], target.platforms)
    return [*own, *tags.compatible_tags(target.version, interpreter, target.platforms)]


def _has_hash(path: str, pin: Pin) -> bool:
    wanted = [one.removeprefix("sha256:") for one in pin.hashes if one.startswith("sha256:")]
    return not wanted or digest_of(path) in wanted


def digest_of(path: str) -> str:
    sha = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1024 * 1024):
            sha.update(block)
    return sha.hexdigest()


def _download(folder: str, pins: Sequence[Pin], target: PythonTarget) -> str:
    """Have pip download wheels for the target; its error if it fails.

    Of packages without one, a wheel is made here: that of pure Python is good for every machine.
    """
    version, interpreter = target.version, f"cp{target.version[0]}{target.version[1]}"
    words = ["download", "--only-binary=:all:", "--dest", folder, "--implementation=cp"]
    words += [f"--python-version={version[0]}.{version[1]}"]
    words += [f"--abi={abi}" for abi in (interpreter, "abi3", "none")]
    words += [f"--platform={platform}" for platform in target.platforms]
    left, without = list(pins), list[Pin]()
    while left and (problem := _pip(words, left)):
        name = pip_messages.missing(problem).replace("-", "_")
        missing = [pin for pin in left if pin.name == name]
        if not missing or len(without) >= _MOST_SOURCES:
            return problem
        without += missing
        left = [pin for pin in left if pin not in missing]
    return _pip(["wheel", "--wheel-dir", folder], without) if without else ""


def _pip(words: Sequence[str], pins: Sequence[Pin]) -> str:
    """Run pip for some pins; the last of its errors, empty if there is none."""
    global _is_offline
    if _is_offline:
        raise _offline(pins)
    command = [sys.executable, "-m", "pip", *words, "--no-deps", "--quiet"]
    # Without a second try pip does not report that it reached nothing.
    command += ["--disable-pip-version-check", "--retries=1", "--timeout=10"]
    with tempfile.NamedTemporaryFile(
        "w", prefix="launcher-", suffix=".txt", encoding="utf-8"
    ) as file:
        # Markers are those of the host, which have been evaluated.
        file.writelines(f"{_without_marker(pin)}\n" for pin in pins)
        file.flush()
        done = subprocess.run(
            [*command, "-r", file.name],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
    if done.returncode == 0:
        return ""
    if pip_messages.is_offline(done.stderr):
        _is_offline = True
        raise _offline(pins)
    return _reason(done.stderr)


def _reason(text: str) -> str:
    """Why pip has failed; for a broken connection its last error is a missing package."""
    broken = pip_messages.broken(text)
    if broken:
        return broken
    lines = text.strip().splitlines() or ["?"]
    errors = [line for line in lines if line.startswith("ERROR") and line != "ERROR: Exception:"]
    return (errors or lines)[-1].removeprefix("ERROR: ")


def _offline(pins: Sequence[Pin]) -> LauncherError:
    return LauncherError(
        f"the wheelhouse lacks {names(pins)}, and pip reaches no index of packages from here",
        hint="repeat it with a network; or run it on a machine that has one, and copy the folder "
        "from there: what is in it is not downloaded again",
    )


def _without_marker(pin: Pin) -> str:
    hashes = "".join(f" --hash={one}" for one in pin.hashes)
    return f"{pin.name.replace('_', '-')}=={pin.version}{hashes}"
