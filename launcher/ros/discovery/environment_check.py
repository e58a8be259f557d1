"""Settings of the environment with which no node can start, or that rcl takes for another."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base.errors import UsageError
from launcher.base.text import did_you_mean
from launcher.packages.finder import search_prefixes
from launcher.posix.domains import RANGES

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_INDEX = "share/ament_index/resource_index/rmw_typesupport"
_LOADER = "rmw_implementation"  # is in the index as well, and is none


def check_environment(environment: Mapping[str, str]) -> None:
    """UsageError; rcl would write another error, and end the process without an exception."""
    installed = _middlewares(environment)
    for variable in ("RMW_IMPLEMENTATION", "RCL_ASSERT_RMW_ID_MATCHES"):
        wanted = environment.get(variable)
        if wanted and installed and wanted not in installed:
            raise UsageError(
                f"{variable} is '{wanted}', a middleware that is not installed",
                hint=did_you_mean(wanted, installed)
                or f"unset it, or set it to {' or '.join(installed)}",
            )
    reach = environment.get(_RANGE)
    if reach and reach not in RANGES and environment.get("ROS_LOCALHOST_ONLY") != "1":
        hint = did_you_mean(reach, RANGES) or f"one of {', '.join(RANGES)}"
        raise UsageError(f"{_RANGE} is '{reach}'", hint=hint)


def _middlewares(environment: Mapping[str, str]) -> list[str]:
    """Those that are installed, sorted; none if it is not known which."""
    found = {
        entry.name
        for prefix in search_prefixes(environment)
        if (prefix / _INDEX).is_dir()
        for entry in (prefix / _INDEX).iterdir()
    }
    return sorted(found - {_LOADER})
