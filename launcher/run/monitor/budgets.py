"""Limits on the resources of a process, and the action when it exceeds them.

Without I/O: `Judge.judge(samples, now)` returns verdicts, which the supervisor carries out.
"""

from __future__ import annotations

import enum
import fnmatch
import re
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType

from launcher.base.model.record import Record
from launcher.base.model.run_events import Sample

FOR_S = 10.0  # a start-up or a garbage collection is over by then
_SUFFIX = re.compile(r"-\d+$")  # of process names: robot_2-4 is the 4th process, from robot_2


class BudgetAction(enum.Enum):
    """The action when a process exceeds its budget for too long."""

    WARN = "warn"
    RESTART = "restart"  # the process
    STOP_RUN = "stop-run"


class Budget(Record):
    """Limits for the processes that `pattern` matches, None for no limit.

    `cpu_percent` is of one core. `memory_bytes` is compared with the USS. Over any limit for
    `for_s` seconds without a break, `action` is due.
    """

    pattern: str
    cpu_percent: float | None = None
    memory_bytes: int | None = None
    threads: int | None = None
    fds: int | None = None
    for_s: float = FOR_S
    action: BudgetAction = BudgetAction.WARN

    def covers(self, process: str, others: Iterable[str] = ()) -> bool:
        """Whether the pattern matches this process; `robot_2` also matches `robot_2-4`.

        `others` are further names of the process, as that of its node.
        """
        names = (process, _SUFFIX.sub("", process), *others)
        return any(fnmatch.fnmatchcase(name, self.pattern) for name in names)


class BudgetExcess(Record):
    """`process` has exceeded one limit of `budget` for `over_s` seconds."""

    process: str
    budget: Budget
    resource: str
    value: float
    limit: float
    over_s: float

    @property
    def action(self) -> BudgetAction:
        return self.budget.action

    def __str__(self) -> str:
        value, limit = (_shown(self.resource, number) for number in (self.value, self.limit))
        return (
            f"{self.process} uses {value}, more than its budget of {limit}, "
            f"for {self.over_s:.0f} s now"
        )


class Judge:
    """Tracks how long processes have exceeded limits; time is an argument.

    Each excess is reported once. A new one begins after a sample below the limit, a restart
    (another pid), or a missing sample.
    """

    def __init__(self, budgets: Iterable[Budget]) -> None:
        self.budgets = tuple(budgets)
        self._stays: dict[tuple[int, str, str, int], _Stay] = {}

    def judge(
        self,
        samples: Mapping[str, Sample],
        now: float,
        names: Mapping[str, Iterable[str]] = MappingProxyType({}),
    ) -> list[BudgetExcess]:
        """The verdicts for new samples, by process name; `now` is monotonic.

        `names` are further names of the processes.
        """
        stays: dict[tuple[int, str, str, int], _Stay] = {}
        verdicts = []
        for process, sample in samples.items():
            for number, budget in enumerate(self.budgets):
                if not budget.covers(process, names.get(process, ())):
                    continue
                for resource, value, limit in _excesses(budget, sample):
                    key = (number, resource, process, sample.pid)
                    stay = self._stays.get(key) or _Stay(since=now)
                    over_s = now - stay.since
                    if not stay.is_reported and over_s >= budget.for_s:
                        stay = _Stay(since=stay.since, is_reported=True)
                        verdicts.append(
                            BudgetExcess(process, budget, resource, value, limit, over_s)
                        )
                    stays[key] = stay
        self._stays = stays
        return verdicts


class _Stay(Record):
    """Above one limit, without a break, since then."""

    since: float
    is_reported: bool = False


def _excesses(budget: Budget, sample: Sample) -> Iterator[tuple[str, float, float]]:
    """(resource, value, limit) of each limit that the sample is above; the unknown is not."""
    for resource, value, limit in (
        ("cpu", sample.cpu_percent, budget.cpu_percent),
        ("memory", sample.uss_bytes, budget.memory_bytes),
        ("threads", sample.threads, budget.threads),
        ("fds", sample.fds, budget.fds),
    ):
        if value is not None and limit is not None and value > limit:
            yield resource, value, limit


def _shown(resource: str, number: float) -> str:
    if resource == "cpu":
        return f"{number:.3g} % CPU" if number < 1000 else f"{number:.0f} % CPU"
    if resource == "memory":
        return f"{number / 1024**2:.1f} MiB (USS)"
    return f"{number:.0f} {'open files' if resource == 'fds' else resource}"
