"""What is to be done when a fault is confirmed or healed: `on:` of a supervision file."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterable

from launcher.base.model.record import Record

WHEN = ("confirmed", "healed")
WITHIN_S = 10.0


class FaultAction(Record):
    """`kind` is restart, stop, start, snapshot, run, webhook or desktop.

    It is done for faults that match `pattern`, `when` they are confirmed or healed, for `within_s`
    at most, and at most `times` in `period_s`. `names` are of processes; `words` the command of
    `run`; `url` that of a webhook, or `$NAME` for one in the environment, as are the values of its
    `headers`: (name, variable). `where` is its place in the file.
    """

    pattern: str
    kind: str
    names: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    url: str = ""
    headers: tuple[tuple[str, str], ...] = ()
    when: str = WHEN[0]
    within_s: float = WITHIN_S
    times: int = 3
    period_s: float = 600.0
    where: str = ""

    def fits(self, fault: str, *, follows: bool) -> bool:
        """Whether it is for this fault; for one that follows from another only by its name."""
        if self.pattern == fault:
            return True
        return not follows and fnmatch.fnmatchcase(fault, self.pattern)

    def may_fit(self, names: Iterable[str]) -> bool:
        """Whether it is for one of these faults; `no deaths: *` is for all that begin like this."""
        head = re.split(r"[*?[]", self.pattern, maxsplit=1)[0]
        for name in names:
            stem = name.removesuffix("*")
            if fnmatch.fnmatchcase(name, self.pattern):
                return True
            if stem != name and (
                head.startswith(stem) or (head != self.pattern and stem.startswith(head))
            ):
                return True
        return False

    @property
    def text(self) -> str:
        """`restart robot_2`, for users; without what may be secret."""
        if self.kind == "run":
            shell = self.words[:2] == ("/bin/sh", "-c")
            return f"run {self.words[2] if shell else ' '.join(self.words)}"
        if self.kind == "webhook":
            return f"webhook {host_of(self.url)}"
        return " ".join((self.kind, *self.names))


def host_of(url: str) -> str:
    """`example.com` of an address: its path may be a secret."""
    return (
        url if url.startswith("$") else url.partition("://")[2].partition("/")[0].partition("?")[0]
    )
