"""Which variables an export writes, and which it only names, since their values may be secret."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

# Settings of ROS and its middleware, of languages and of Python: nothing to hide.
_PUBLIC = re.compile(
    r"(ROS|RMW|RCL|RCUTILS|FASTDDS|FASTRTPS|CYCLONEDDS|LC|PYTHON)_?[A-Z0-9_]*|LANG|TZ"
)
_SECRET = re.compile(
    r"(?i)(secret|passw|passphrase|credential|token|private|api_?key|(^|_)(key|pwd|auth|cookie)(_|$))"
)


def looks_secret(name: str) -> bool:
    return _SECRET.search(name) is not None


def divided(
    of_launch_file: Mapping[str, str],
    of_host: Mapping[str, str],
    secrets: Collection[str] = (),
) -> tuple[dict[str, str], tuple[str, ...]]:
    """(variables to write, names of those that are private).

    Variables of the hosts file are private unless they are settings of ROS; those of the launch
    file, in which everybody can read them, only if their name says so.
    """
    given = {**of_launch_file, **of_host}
    private = {name for name in given if looks_secret(name)} | {*secrets}
    private |= {name for name in of_host if not _PUBLIC.fullmatch(name)}
    written = {name: value for name, value in sorted(given.items()) if name not in private}
    return written, tuple(sorted(private))
