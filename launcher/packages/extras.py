"""How to install an extra of this distribution."""

from __future__ import annotations

import functools
import importlib.util
import os
import shlex
import sys
from importlib import metadata
from importlib.machinery import PathFinder
from pathlib import Path
from urllib.parse import unquote, urlsplit

from launcher.base import strict_json
from launcher.base.errors import UsageError

DISTRIBUTION = "ros2-launcher"
# To be looked for in folders only. A finder of setuptools that is asked for pip takes this process
# for pip's: before Python 3.12 setuptools can then not be imported (pypa/pip#8761).
PATH_ONLY = frozenset({"pip"})
_FOLDER = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


@functools.cache
def install_command(extra: str) -> str:
    """The command that installs an extra the way this distribution is installed."""
    if is_installed("pip"):
        install = [sys.executable, "-m", "pip", "install"]
    else:
        install = ["uv", "pip", "install", "--python", sys.executable]
    return shlex.join([*install, *_requirement(_direct_url(), extra)])


def is_installed(name: str) -> bool:
    """Whether Python finds a module."""
    try:
        find_spec = PathFinder.find_spec if name in PATH_ONLY else importlib.util.find_spec
        return find_spec(name) is not None
    except (ImportError, ValueError):
        return False


def require(extra: str, package: str, what: str) -> None:
    """UsageError with the command that installs the extra if its package is missing.

    `what` needs it: "watching files".
    """
    if not is_installed(package):
        raise UsageError(
            f"{what} needs the Python package '{package}', which is not installed",
            hint=install_command(extra),
        )


def _direct_url() -> dict[str, object]:
    try:
        text = metadata.distribution(DISTRIBUTION).read_text("direct_url.json")
    except metadata.PackageNotFoundError:
        text = None
    if text is not None:
        found: dict[str, object] = strict_json.loads(text)
        return found
    editable = os.path.isfile(os.path.join(_FOLDER, "pyproject.toml"))
    return {"url": Path(_FOLDER).as_uri(), "dir_info": {"editable": True}} if editable else {}


def _requirement(origin: dict[str, object], extra: str) -> list[str]:
    """The words that name this distribution with an extra; `origin` is its `direct_url.json`."""
    url = str(origin.get("url", ""))
    name = f"{DISTRIBUTION}[{extra}]"
    if isinstance(info := origin.get("dir_info"), dict):
        words = ["--editable"] if info.get("editable") else []
        return [*words, f"{unquote(urlsplit(url).path)}[{extra}]"]
    if isinstance(source := origin.get("vcs_info"), dict):
        url = f"{source['vcs']}+{url}@{source['commit_id']}"
    below = f"#subdirectory={origin['subdirectory']}" if "subdirectory" in origin else ""
    return [f"{name} @ {url}{below}" if url else name]
