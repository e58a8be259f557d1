"""Secrets that command lines, texts and environments of a run may hold are replaced by `***`."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

HIDDEN = "***"
# Variables that say how nodes find each other; of all others not even the name is kept.
VARIABLES = frozenset(
    {
        "AMENT_PREFIX_PATH",
        "CYCLONEDDS_URI",
        "FASTDDS_DEFAULT_PROFILES_FILE",
        "FASTRTPS_DEFAULT_PROFILES_FILE",
        "RCUTILS_LOGGING_MIN_SEVERITY",
        "RMW_FASTRTPS_USE_QOS_FROM_XML",
        "RMW_IMPLEMENTATION",
        "ROS_AUTOMATIC_DISCOVERY_RANGE",
        "ROS_DISCOVERY_SERVER",
        "ROS_DISTRO",
        "ROS_DOMAIN_ID",
        "ROS_LOCALHOST_ONLY",
        "ROS_STATIC_PEERS",
        "ROS_VERSION",
        "USE_SIM_TIME",
    }
)
_ENVIRONMENTS = frozenset({"env", "env_set", "env_unset", "env_names", "environment"})
# Lengths are bounded, so that no text takes more than linear time.
_NAME = (
    r"(?:[\w.-]{0,60}(?:pass(?:word|wd|phrase)|secret|token|credential|api[_-]?key|"
    r"access[_-]?key|private[_-]?key|auth[_-]?key)(?:[_.-][\w.-]{0,60})?|[\w.-]{0,60}[_-]pass|"
    r"(?:[\w.-]{0,60}[_.-])?(?:pwd|psk)|authorization)"
)
_KEY = re.compile(rf"-{{0,2}}{_NAME}", re.IGNORECASE)
_VALUE = r"""(?:"[^"]*"|'[^']*'|(?:(?:bearer|basic|digest)\s+)?[^\s,;&'"<>)\]}]+)"""
_ASSIGNED = re.compile(
    rf"""(?<![\w.-])(-{{0,2}}{_NAME}["']?\s?(?::=|=>|=|:)\s?){_VALUE}""", re.IGNORECASE
)
_FLAG = re.compile(rf"(?<!\S)(--?{_NAME}\s+)(?!-)\S+", re.IGNORECASE)
_BEARER = re.compile(r"\b(bearer\s+)[\w.~+/=-]{8,}", re.IGNORECASE)
_IN_URL = re.compile(r"(\b[a-z][a-z0-9+.-]{1,20}://)[^\s/@]{1,200}@", re.IGNORECASE)
# What services issue, by the forms that they have published.
_ISSUED = re.compile(
    r"\b(?:gh[pousr]_\w{20,}|github_pat_\w{20,}|glpat-[\w-]{16,}|xox[abprs]-[\w-]{10,}|"
    r"(?:AKIA|ASIA)[0-9A-Z]{16}|sk-[\w-]{20,}|AIza[\w-]{30,}|"
    r"eyJ[\w-]{8,999}\.[\w-]{8,9999}\.[\w-]{8,})"
)
_PEM = re.compile(
    r"-----BEGIN [A-Z ]*PRIVATE KEY-----.*?(?:-----END [A-Z ]*PRIVATE KEY-----|\Z)", re.DOTALL
)
_HINT = re.compile(
    r"pass|secret|token|credential|key|pwd|psk|auth|bearer|://|_|-[\w-]|eyJ|A[IK]", re.I
)


def without_secrets(text: str) -> str:
    """The text with `***` in place of passwords, tokens and keys that are recognized."""
    if not _HINT.search(text):
        return text
    text = _PEM.sub(HIDDEN, text)
    text = _IN_URL.sub(rf"\1{HIDDEN}@", text)
    text = _ASSIGNED.sub(rf"\1{HIDDEN}", text)
    text = _FLAG.sub(rf"\1{HIDDEN}", text)
    text = _BEARER.sub(rf"\1{HIDDEN}", text)
    return _ISSUED.sub(HIDDEN, text)


def words_without_secrets(words: Sequence[str]) -> list[str]:
    """A command line; the word behind `--password` is hidden, too."""
    found: list[str] = []
    is_secret = False
    for word in words:
        hides = is_secret and not word.startswith("-")
        found.append(HIDDEN if hides else without_secrets(word))
        is_secret = word.startswith("-") and bool(_KEY.fullmatch(word))
    return found


def document_without_secrets(value: Any) -> Any:
    """A JSON value, all its texts and keys included; of environments `VARIABLES` are kept."""
    if isinstance(value, str):
        return without_secrets(value)
    if isinstance(value, Mapping):
        return {without_secrets(str(key)): _of_key(str(key), one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        kinds = set(map(type, value))
        if kinds <= {int, float, bool, type(None)}:
            return value  # most of a document are numbers
        if kinds == {str}:
            return words_without_secrets(value)
        return [document_without_secrets(one) for one in value]
    return value


def _of_key(key: str, value: Any) -> Any:
    if key in _ENVIRONMENTS:
        return _environment(value)
    if _KEY.fullmatch(key) and isinstance(value, (str, int, float)) and not isinstance(value, bool):
        return HIDDEN
    return document_without_secrets(value)


def _environment(value: Any) -> Any:
    """The variables that are kept; None if it is neither an object nor a list of names."""
    if isinstance(value, Mapping):
        return {
            name: document_without_secrets(one) for name, one in value.items() if name in VARIABLES
        }
    if isinstance(value, (list, tuple)):
        return [one for one in value if isinstance(one, str) and one in VARIABLES]
    return None
