"""Collects the variables of ROS and of the middleware, and whether what they name can be read."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping

from launcher.base import strict_json, text_file, xml_tree
from launcher.base.errors import UsageError
from launcher.doctor.doctor_facts import SettingsFacts
from launcher.packages.distribution import has_fast_dds_3
from launcher.posix.crowd import PROFILES
from launcher.ros.discovery.environment_check import check_environment

FASTDDS_ENVIRONMENT, CYCLONE, KEYSTORE = (
    "FASTDDS_ENVIRONMENT_FILE",
    "CYCLONEDDS_URI",
    "ROS_SECURITY_KEYSTORE",
)
NAMES = (
    *PROFILES,
    FASTDDS_ENVIRONMENT,
    CYCLONE,
    KEYSTORE,
    "FASTDDS_BUILTIN_TRANSPORTS",
    "RCUTILS_COLORIZED_OUTPUT",
    "RCUTILS_LOGGING_BUFFERED_STREAM",
    "RCUTILS_LOGGING_USE_STDOUT",
    "RMW_FASTRTPS_PUBLICATION_MODE",
    "RMW_IMPLEMENTATION",
    "ROS_LOCALHOST_ONLY",
    "ROS_SECURITY_ENABLE",
    "ROS_SECURITY_STRATEGY",
)
_FILE = "file://"


def collect_settings(env: Mapping[str, str]) -> SettingsFacts:
    values = {name: env[name] for name in NAMES if env.get(name)}
    return SettingsFacts(
        values=values,
        faults=dict(_faults(values)),
        refusal=_refusal(env),
        has_fast_dds_3=has_fast_dds_3(env),
    )


def _refusal(env: Mapping[str, str]) -> tuple[str, str] | None:
    try:
        check_environment(env)
    except UsageError as error:
        return error.message, error.hint or ""
    return None


def _faults(values: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """(variable, why what it names cannot be read)."""
    for name in PROFILES:
        if name in values and (fault := _file_fault(values[name], _xml("dds", "profiles"))):
            yield name, fault
    if FASTDDS_ENVIRONMENT in values:
        fault = _file_fault(values[FASTDDS_ENVIRONMENT], strict_json.loads)
        if fault:
            yield FASTDDS_ENVIRONMENT, fault
    for part in values.get(CYCLONE, "").split(","):
        path = part.strip().removeprefix(_FILE)
        is_path = part.strip().startswith(_FILE)
        if is_path and (fault := _file_fault(path, _xml("CycloneDDS"))):
            yield CYCLONE, fault
    if KEYSTORE in values and not os.path.isdir(os.path.join(values[KEYSTORE], "enclaves")):
        yield KEYSTORE, f"{values[KEYSTORE]} has no folder enclaves"


def _file_fault(path: str, read: Callable[[str], object]) -> str | None:
    """Why a file cannot be read; None if it can."""
    if os.path.lexists(path) and not os.path.isfile(path):
        return f"{path} is no file"
    try:
        read(text_file.read(path).removeprefix("\ufeff"))
    except OSError as error:
        return f"{path}: {error.strerror}"
    except xml_tree.XmlError as error:
        place = f" in line {error.line}" if error.line else ""
        return f"{path}: {error.message}{place}"
    except ValueError as error:
        return f"{path}: {error}"
    return None


def _xml(*roots: str) -> Callable[[str], None]:
    """Reads XML whose first tag is one of these; ValueError, XmlError."""

    def read(text: str) -> None:
        tag = xml_tree.parse(text).name.rpartition("}")[2]
        if tag not in roots:
            raise ValueError(f"its first tag is <{tag}>, not <{'> or <'.join(roots)}>")

    return read
