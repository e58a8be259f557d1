"""Absent: the verbs of ros2cli that are not built here, and what there is instead."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence

from launcher.errors import PackageNotFoundError, UsageError
from launcher.frontends.locate import locate
from launcher.packages import share_directory

_CALL = "python -m launcher service call"
INSTEAD = {
    "action": "topic list and service list show what an action is made of, "
    "with --include-hidden-topics and --include-hidden-services",
    "bag": "python -m launcher topic echo TOPIC --json > FILE keeps messages, one in a line",
    "component": "a launch file loads components (ComposableNodeContainer, LoadComposableNodes)",
    "control": None,
    "daemon": "there is no daemon, and nothing waits for one",
    "extension_points": None,
    "extensions": None,
    "lifecycle": f"{_CALL} /NODE/get_state lifecycle_msgs/srv/GetState, "
    "and change_state with ChangeState",
    "multicast": None,
    "pkg": "python -m launcher run PACKAGE lists the executables of a package, "
    "interface list the types of all",
    "plugin": None,
    "security": None,
    "test": "python -m launcher smoke TARGET tests a launch file",
    "trace": None,
    "wtf": "python -m launcher doctor",
}


def refuse(words: Sequence[str]) -> None:
    """UsageError if the first word is such a verb, and no launch file or package is called so."""
    verb = words[0]
    if verb in INSTEAD and not _is_target(words):
        raise UsageError(
            f"ros2cli's verb '{verb}' does not exist here",
            hint=INSTEAD[verb] or "python -m launcher --help lists the verbs that do",
        )


def _is_target(words: Sequence[str]) -> bool:
    with contextlib.suppress(UsageError):
        locate(words[:1], os.environ)
        return True
    with contextlib.suppress(PackageNotFoundError):
        share_directory(words[0], os.environ)
        return len(words) > 1
    return False
