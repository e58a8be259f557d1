"""What messages of a pip that has failed mean."""

from __future__ import annotations

import re

# A warning before another try, which may succeed: the reason, and the page or its path.
_BROKEN = re.compile(r"connection broken by '(.*)': (\S+)")
_MISSING = re.compile(r"No matching distribution found for ([A-Za-z0-9._-]+)")
_INSTALL_ROS = (
    "there are no wheels of ROS 2 for its machine and version of Python: install ROS 2 there, "
    "and name its set-up file by `setup:` in the hosts file"
)
_NO_CONNECTION = (
    *("NewConnectionError", "NameResolutionError", "ConnectTimeout", "Failed to establish"),
    "ProxyError",
    *("Temporary failure in name resolution", "Name or service not known"),
    *("Network is unreachable", "No route to host"),
)


def missing(text: str) -> str:
    """The package that pip has not found, in lower case with `-`; empty if it is another error."""
    found = _MISSING.findall(text)
    return _canonical(found[-1]) if found else ""


def advice(text: str) -> str:
    """What to do about a package of ROS 2 that pip has not found; empty if it is another error."""
    return _INSTALL_ROS if missing(text).startswith("ros-") else ""


def broken(text: str) -> str:
    """Why pip could not read the page of the package that it has not found, if that is why."""
    name = missing(text)
    reasons = [why for why, page in _BROKEN.findall(text) if name and name == _last(page)]
    return reasons[-1] if reasons else ""


def is_offline(text: str) -> bool:
    """Whether these are messages of a pip that reaches no index."""
    if missing(text):
        why = broken(text)
        return "ReadTimeout" in why or _is_without_connection(why)
    lines = [line for line in text.splitlines() if not _BROKEN.search(line)]
    return _is_without_connection("\n".join(lines))


def _is_without_connection(text: str) -> bool:
    return any(words in text for words in _NO_CONNECTION)


def _last(page: str) -> str:
    return _canonical(page.rstrip("/").rpartition("/")[2])


def _canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower().strip("-")
