"""Rejects an invalid ROS_DOMAIN_ID before nodes are started that would exit because of it."""

from __future__ import annotations

import re
from collections.abc import Iterable

from launcher.errors import UsageError
from launcher.ros.discovery.ports import MAX_DOMAIN

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.model.events import Effect

VARIABLE = "ROS_DOMAIN_ID"
# As rcl reads it, with C's strtoul: what follows the digits does not count, except after a 0.
_NUMBER = re.compile(r"\s*([+-]?)(0x[0-9a-f]+|0[0-7]*|[1-9][0-9]*)", re.ASCII | re.IGNORECASE)
_MOST_NAMES = 3


def is_domain(word: str) -> bool:
    """Whether a node with this value of ROS_DOMAIN_ID can start."""
    if not word:
        return True
    found = _NUMBER.match(word)
    if found is None:
        return False
    sign, digits = found.groups()
    is_octal = digits.startswith("0") and digits[1:2] not in ("x", "X")
    number = int(digits, 8 if is_octal else 0)
    if number == 0:
        return found.end() == len(word)
    return sign != "-" and number <= MAX_DOMAIN


def refuse(word: str, effects: Iterable[Effect]) -> None:
    """UsageError if a node would get this invalid value from the environment."""
    from launcher.model.events import StartProcess

    if is_domain(word):
        return
    specs = [effect.spec for effect in effects if isinstance(effect, StartProcess)]
    nodes = [spec.name for spec in specs if spec.ros and spec.env.get(VARIABLE) == word]
    if not nodes:
        return
    names = ", ".join(nodes[:_MOST_NAMES])
    more = f" and {len(nodes) - _MOST_NAMES} more" if len(nodes) > _MOST_NAMES else ""
    raise UsageError(
        f"{VARIABLE} is '{word}', with which no node can start ({names}{more})",
        hint=f"a domain is a number from 0 to {MAX_DOMAIN}: export {VARIABLE}=0, or unset it",
    )
