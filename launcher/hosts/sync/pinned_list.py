"""The pinned list of an environment of Python, and which of it a host needs."""

from __future__ import annotations

import hashlib
import importlib
import os
from collections.abc import Iterator, Mapping, Sequence
from importlib import metadata
from typing import Any

from launcher.base.errors import LauncherError, UsageError
from launcher.base.model.record import Record
from launcher.base.text import several
from launcher.packages import distribution

# With the wheels of Jazzy; there is a list for each other distribution with wheels, too.
_CHECKOUT = os.path.join("requirements", "run.txt")


class Pin(Record):
    """A package with its version, `name` in the spelling of file names; `line` is as written."""

    name: str
    version: str
    line: str
    hashes: tuple[str, ...] = ()


class PinnedList(Record):
    """`text` is what pip reads; `where` names the list in messages."""

    text: str
    where: str

    @property
    def digest(self) -> str:
        """The same for lists that differ in comments and order only."""
        lines = sorted(line for _, line in _logical_lines(self.text))
        return hashlib.sha256("\n".join(lines).encode("utf-8", "replace")).hexdigest()


def read(path: str) -> PinnedList:
    """UsageError if the list cannot be read, or leads to other files."""
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except (OSError, UnicodeDecodeError) as error:
        problem = getattr(error, "strerror", None) or str(error)
        raise UsageError(f"--requirements: {path}: {problem}") from None
    for number, line in _logical_lines(text):
        if line.startswith(("-r", "-c", "-e", "--requirement", "--constraint", "--editable", ".")):
            raise UsageError(
                f"'{line}' leads to files that the hosts do not have",
                where=f"{path}:{number}",
                hint="make one list of all packages: pip freeze, or uv pip compile",
            )
    return PinnedList(text=text, where=path)


def default() -> PinnedList:
    """That of the launcher's checkout for the ROS 2 in use, else the versions that are installed
    here: without wheels of ROS 2 where that has none.
    """
    here = os.path.dirname(os.path.dirname(importlib.import_module("launcher").__file__ or ""))
    path = os.path.join(here, _CHECKOUT)
    name = distribution.or_default()
    if name != distribution.DEFAULT:
        path = path.replace(".txt", f"-{name}.txt")
    if os.path.isfile(path):
        return read(path)
    lines = sorted(_installed())
    if not lines:
        raise UsageError(
            "which packages the hosts need is not known: the launcher is not installed by pip",
            hint="--requirements FILE names a list with their versions",
        )
    return PinnedList(text="\n".join(lines) + "\n", where="the versions that are installed here")


def pins(listed: PinnedList, markers: Mapping[str, str]) -> list[Pin]:
    """What a host with these marker variables needs; UsageError if a version is not pinned."""
    return [
        pin
        for number, line in _logical_lines(listed.text)
        if (pin := _pin(line, markers, f"{listed.where}:{number}"))
    ]


def packaging(module: str) -> Any:
    """A module of `packaging`, which pip contains as well; LauncherError."""
    for package in ("packaging", "pip._vendor.packaging"):
        try:
            return importlib.import_module(f"{package}.{module}")
        except ImportError:
            continue
    raise LauncherError("wheels cannot be chosen without pip", hint="python -m ensurepip")


def _pin(line: str, markers: Mapping[str, str], where: str) -> Pin | None:
    if line.startswith("-"):
        return None  # an option of pip
    words = line.split(" --hash=")
    requirements = packaging("requirements")
    try:
        found = requirements.Requirement(words[0].strip())
    except requirements.InvalidRequirement as error:
        raise UsageError(f"'{words[0]}' is no requirement: {error}", where=where) from None
    if found.marker is not None and not found.marker.evaluate({**markers, "extra": ""}):
        return None
    exact = [one.version for one in found.specifier if one.operator in ("==", "===")]
    if len(exact) != 1 or exact[0].endswith(".*"):
        raise UsageError(
            f"'{words[0]}' has no exact version",
            where=where,
            hint="an environment without a network needs a complete list with versions: "
            "pip freeze, or uv pip compile",
        )
    name = packaging("utils").canonicalize_name(found.name).replace("-", "_")
    hashes = tuple(word.strip() for word in words[1:])
    return Pin(name=name, version=exact[0], line=line, hashes=hashes)


def _logical_lines(text: str) -> Iterator[tuple[int, str]]:
    """(number, line) without comments, continued lines joined."""
    parts: list[str] = []
    for number, line in enumerate(text.splitlines(), start=1):
        stripped = line.strip()
        if stripped.startswith("#"):
            stripped = ""
        is_continued = stripped.endswith("\\")
        parts.append(stripped.removesuffix("\\").partition(" #")[0].strip())
        if not is_continued:
            joined = " ".join(part for part in parts if part)
            parts = []
            if joined:
                yield number, joined


def _installed() -> Iterator[str]:
    """`name==version` of what the launcher's distribution requires, as it is installed here."""
    requirements, utils = packaging("requirements"), packaging("utils")
    known = {utils.canonicalize_name(one.metadata["Name"]): one for one in metadata.distributions()}
    ours = [one for one in known.values() if _has_launcher(one)]
    of_ros = distribution.or_default()  # no extra without wheels
    wanted = [(one, extra) for one in ours for extra in ("", of_ros)]
    seen = set(map(str, wanted))
    for one_of, extra in wanted:
        for line in one_of.requires or ():
            found = requirements.Requirement(line)
            if found.marker is not None and not found.marker.evaluate({"extra": extra}):
                continue
            needed = known.get(utils.canonicalize_name(found.name))
            if needed is None:
                continue
            for one in ("", *found.extras):
                if (key := f"{found.name}[{one}]") not in seen:
                    seen.add(key)
                    wanted.append((needed, one))
            if f"{found.name}==" not in seen:
                seen.add(f"{found.name}==")
                yield f"{found.name}=={needed.version}"


def _has_launcher(one: Any) -> bool:
    return "launcher" in (one.read_text("top_level.txt") or "").split()


def names(found: Sequence[Pin]) -> str:
    """`numpy==2.4.6, rich==15.0.0 and 3 more`."""
    return several(f"{pin.name}=={pin.version}" for pin in found)
