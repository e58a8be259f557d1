"""The checks of `doctor` about variables of ROS: wrong values, files that cannot be read."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.base.model.level import Level
from launcher.base.text import did_you_mean
from launcher.doctor.doctor_facts import Finding, SettingsFacts
from launcher.doctor.settings import CYCLONE, FASTDDS_ENVIRONMENT, KEYSTORE
from launcher.posix.crowd import PROFILES

_FAST, _CYCLONE = "rmw_fastrtps", "rmw_cyclonedds"
_ENABLE, _STRATEGY = "ROS_SECURITY_ENABLE", "ROS_SECURITY_STRATEGY"
_NO_LOG = "nodes print errors instead of their log"
# Variable -> what it may be, and what happens otherwise; `X?OPTIONS` counts as X.
_CHOICES = {
    "FASTDDS_BUILTIN_TRANSPORTS": (
        ("NONE", "DEFAULT", "DEFAULTv6", "SHM", "UDPv4", "UDPv6", "LARGE_DATA", "LARGE_DATAv6"),
        "Fast DDS takes it for DEFAULT",
    ),
    "RMW_FASTRTPS_PUBLICATION_MODE": (
        ("SYNCHRONOUS", "ASYNCHRONOUS", "AUTO"),
        "rmw_fastrtps takes it for SYNCHRONOUS",
    ),
    "ROS_LOCALHOST_ONLY": (("0", "1"), "rcl takes it for 0"),
    "ROS_SECURITY_ENABLE": (("true", "false"), "rcl takes it for false: nodes have no security"),
    "ROS_SECURITY_STRATEGY": (("Enforce", "Permissive"), "rcl takes it for Permissive"),
    "RCUTILS_COLORIZED_OUTPUT": (("0", "1"), _NO_LOG),
    "RCUTILS_LOGGING_BUFFERED_STREAM": (("0", "1"), _NO_LOG),
    "RCUTILS_LOGGING_USE_STDOUT": (("0", "1"), _NO_LOG),
}

Mistake = tuple[Level, str, str]  # with what to do


def check_settings(facts: SettingsFacts) -> list[Finding]:
    """One finding for each mistake, or one that there is none."""
    refused = [] if facts.refusal is None else [(Level.PROBLEM, *facts.refusal)]
    found = [*refused, *_choices(facts), *_files(facts), *_security(facts)]
    if not found:
        return [Finding("environment", Level.OK, "no variable of ROS is wrong")]
    return [Finding("environment", level, text, advice) for level, text, advice in found]


def _choices(facts: SettingsFacts) -> Iterator[Mistake]:
    for name, (known, effect) in _CHOICES.items():
        value = facts.values.get(name)
        if value is not None and value.partition("?")[0] not in known:
            hint = did_you_mean(value, known) or f"one of {', '.join(known)}, or unset it"
            yield Level.PROBLEM, f"{name} is '{value}': {effect}", hint


def _files(facts: SettingsFacts) -> Iterator[Mistake]:
    """Of the middleware in use; another one does not read them."""
    middleware = facts.values.get("RMW_IMPLEMENTATION", _FAST)
    repair = "correct the path or the file, or unset it"
    for name in (*PROFILES, FASTDDS_ENVIRONMENT):
        if name in facts.faults and middleware.startswith(_FAST):
            text = f"{name} has no effect: {facts.faults[name]}"
            yield Level.PROBLEM, text, repair
    old, new = PROFILES
    is_alone = new in facts.values and old not in facts.values
    if is_alone and not facts.has_fast_dds_3 and new not in facts.faults:
        text = f"{new} has no effect: Fast DDS 2 reads {old}"
        yield Level.PROBLEM, text, f"set {old}, too"
    if CYCLONE in facts.faults and middleware.startswith(_CYCLONE):
        text = f"{CYCLONE} names what Cyclone DDS cannot read: {facts.faults[CYCLONE]}"
        yield Level.PROBLEM, text, repair


def _security(facts: SettingsFacts) -> Iterator[Mistake]:
    values = facts.values
    if values.get(_ENABLE) != "true" or (KEYSTORE in values and KEYSTORE not in facts.faults):
        return
    why = facts.faults.get(KEYSTORE, f"{KEYSTORE} is not set")
    advice = f"set {KEYSTORE} to a folder that sros2 has made, or unset {_ENABLE}"
    if values.get(_STRATEGY) == "Enforce":
        yield Level.PROBLEM, f"{_ENABLE} is true, and {why}: no node can start", advice
    else:
        yield Level.PROBLEM, f"{_ENABLE} is true, and {why}: nodes start without security", advice
