"""The extra `build` of this distribution: what building needs, and how to install it."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shlex
import sys
from importlib import metadata
from pathlib import Path
from urllib.parse import unquote, urlsplit

from launcher.errors import LauncherError

_DISTRIBUTION = "group_gp1"
_EXTRA = re.compile(r"""extra\s*==\s*['"]build['"]""")
_CHECKOUT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def require() -> None:
    """LauncherError with the command that installs what is missing."""
    lacking = missing()
    if not lacking:
        return
    shown = ", ".join(lacking[:3]) + (f" and {len(lacking) - 3} more" if len(lacking) > 3 else "")
    raise LauncherError(
        f"building needs packages that are not installed: {shown}",
        hint=f"install them once: {install_command()}",
    )


def missing() -> list[str]:
    """The requirements of the extra that are not installed, or in a version that does not fit."""
    try:
        wanted = [one for one in metadata.requires(_DISTRIBUTION) or () if _EXTRA.search(one)]
    except metadata.PackageNotFoundError:
        wanted = []
    if not wanted:  # not installed, or by a version without the extra
        return ["colcon-core"] if importlib.util.find_spec("colcon_core") is None else []
    return [name for name in map(_lacking, wanted) if name]


def _lacking(requirement: str) -> str | None:
    text = requirement.partition(";")[0].strip()
    name = re.split(r"[^\w.-]", text, maxsplit=1)[0]
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        return name
    bound = text[len(name) :].strip()
    return None if _fits(version, bound) else f"{text} (there is {version})"


def _fits(version: str, bound: str) -> bool:
    if not bound or importlib.util.find_spec("packaging") is None:
        return True
    from packaging.specifiers import SpecifierSet

    return SpecifierSet(bound.strip("()")).contains(version, prereleases=True)


def install_command() -> str:
    """The command that installs the extra the way this distribution is installed."""
    if importlib.util.find_spec("pip") is not None:
        install = [sys.executable, "-m", "pip", "install"]
    else:
        install = ["uv", "pip", "install", "--python", sys.executable]
    return shlex.join([*install, *_requirement(_direct_url())])


def _direct_url() -> dict[str, object]:
    try:
        text = metadata.distribution(_DISTRIBUTION).read_text("direct_url.json")
    except metadata.PackageNotFoundError:
        text = None
    if text is not None:
        found: dict[str, object] = json.loads(text)
        return found
    editable = os.path.isfile(os.path.join(_CHECKOUT, "setup.py"))
    return {"url": Path(_CHECKOUT).as_uri(), "dir_info": {"editable": True}} if editable else {}


def _requirement(origin: dict[str, object]) -> list[str]:
    """The words that name this distribution with its extra; `origin` is its `direct_url.json`."""
    url = str(origin.get("url", ""))
    if isinstance(info := origin.get("dir_info"), dict):
        words = ["--editable"] if info.get("editable") else []
        return [*words, f"{unquote(urlsplit(url).path)}[build]"]
    if isinstance(source := origin.get("vcs_info"), dict):
        return [f"{_DISTRIBUTION}[build] @ {source['vcs']}+{url}@{source['commit_id']}"]
    return [f"{_DISTRIBUTION}[build] @ {url}" if url else f"{_DISTRIBUTION}[build]"]
