"""Names that are different in every run, as those with a pid or a random number, as patterns."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence

# A UUID, a hexadecimal number, or a long decimal one: anonymous names have a pid and a time.
_RANDOM = re.compile(
    r"[0-9a-f]{8}[-_]?(?:[0-9a-f]{4}[-_]?){3}[0-9a-f]{12}"
    r"|(?<![0-9A-Za-z])(?=[a-z]*\d)[0-9a-f]{8,}(?![0-9A-Za-z])"
    r"|\d{4,}"
)
_NUMBER = re.compile(r"(?<![A-Za-z])[0-9a-f]*\d[0-9a-f]*(?![A-Za-z])|\d+")
_STARS = re.compile(r"\*(?:[-_.]?\*)+")


def without_random(name: str, pids: Collection[int] = ()) -> str:
    """The name with `*` for what is certainly not the same in the next run."""
    found = _RANDOM.sub("*", name)
    found = re.sub(r"\d+", lambda m: "*" if int(m[0]) in pids and len(m[0]) > 1 else m[0], found)
    return _STARS.sub("*", found)


def without_numbers(name: str) -> str:
    """The name with `*` for every number in it."""
    return _STARS.sub("*", _NUMBER.sub("*", _RANDOM.sub("*", name)))


class Names:
    """The names of a kind in each of several runs, and what they have in common.

    `pids`: of each run; a name that contains one is another in the next run.
    """

    def __init__(self, runs: Sequence[Iterable[str]], pids: Sequence[Collection[int]]) -> None:
        self._runs = [frozenset(run) for run in runs]
        self._pids = pids
        self._patterns = [
            {self._pattern(name, number) for name in names}
            for number, names in enumerate(self._runs)
        ]

    def _pattern(self, name: str, run: int) -> str:
        if len(self._runs) == 1:
            return without_random(name, self._pids[run])
        return name if all(name in names for names in self._runs) else without_numbers(name)

    def of(self, name: str, run: int) -> str | None:
        """The name, a pattern of it, or None if not every run has one."""
        pattern = self._pattern(name, run)
        return pattern if all(pattern in patterns for patterns in self._patterns) else None

    def common(self) -> list[str]:
        """The names and patterns of all runs, sorted."""
        return sorted(frozenset.intersection(*map(frozenset, self._patterns)))

    def missing(self) -> list[str]:
        """The names that only some runs have."""
        found = {
            name
            for number, names in enumerate(self._runs)
            for name in names
            if self.of(name, number) is None
        }
        return sorted(found)


def is_pattern(name: str) -> bool:
    return "*" in name
