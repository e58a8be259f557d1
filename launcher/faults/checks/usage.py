"""Memory and CPU of processes, over the last seconds."""

from __future__ import annotations

import statistics

from launcher.faults.checks.check import ExpectationCheck, absence
from launcher.faults.model.fault import FaultFinding
from launcher.faults.model.fault_life import Debounce
from launcher.faults.watcher.story import Story
from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.observe.facts import matches

MIB = 1024 * 1024
CPU_WINDOW_S = 10.0
GROWTH_WINDOW_S = 60.0
START_UP_S = 10.0  # a process that has just started grows
LEAST_GROWTH = 4 * MIB  # less is the allocator
# It has not begun to grow where it is above the smallest size by less than one of these: the noise
# of a process that does not grow, and a part of all that it has grown.
STILL_BYTES, STILL_PART = LEAST_GROWTH / 8, 0.1


class UsageCheck(ExpectationCheck):
    """Of each process that the pattern matches; the fault is about all of them."""

    debounce = Debounce(confirm_s=1.0, heal_s=5.0)

    def absent(self, story: Story) -> FaultFinding | None:
        return absence(str(self.expectation.subject), story)

    def running(self, story: Story) -> list[str]:
        pattern = str(self.expectation.subject)
        return [
            str(row["name"])
            for row in story.rows
            if row["state"] == "RUNNING" and matches(pattern, row["name"], tuple(row["node_names"]))
        ]

    def series(
        self, story: Story, name: str, window_s: float
    ) -> list[tuple[float, float | None, int | None]]:
        """(time, CPU in percent, RSS in bytes) of the window, without the start of the process."""
        row = story.row(name)
        uptime_s = 0.0 if row is None else float(row["uptime_s"] or 0.0)
        from_s = story.now_s - min(window_s, max(0.0, uptime_s - START_UP_S))
        return [one for one in story.samples.get(name, ()) if one[0] >= from_s]


class CpuCheck(UsageCheck):
    """The mean of ten seconds (`below`), and every sample (`peak`)."""

    def __init__(self, expectation: Expectation) -> None:
        below, peak = expectation.get("below"), expectation.get("peak")
        self._below = float("inf") if below is None else float(below)
        self._peak = float("inf") if peak is None else float(peak)
        limits = [f"{self._below:g} % on average"] if below is not None else []
        limits += [f"{self._peak:g} % at any moment"] if peak is not None else []
        super().__init__(expectation, f"CPU of {expectation.subject} below {', '.join(limits)}")

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        if (absent := self.absent(story)) is not None:
            return True, absent
        is_known, worst, seen = False, "", ""
        most = 0.0
        for name in self.running(story):
            loads = [cpu for _, cpu, _ in self.series(story, name, CPU_WINDOW_S) if cpu is not None]
            if len(loads) < 3:
                continue
            is_known = True
            mean = statistics.fmean(loads)
            if (mean >= self._below or max(loads) >= self._peak) and mean > most:
                most, worst = mean, name
                seen = f"{name} {mean:.0f} % on average, {max(loads):.0f} % at most"
        if not worst:
            return is_known, None
        return True, FaultFinding(seen=seen, value=most, unit="%", processes=(worst,))


class MemoryCheck(UsageCheck):
    """The size now (`below`, USS), and how much it has grown in a minute (`growth`, RSS).

    The growth is that from the smallest to the last size of the window: it is above what may be
    grown in a whole window, so a process that grows fast is found before the minute is over. What
    is reported is the growth since it began, which may be long after the start of the window.
    """

    debounce = Debounce(confirm_s=0.7, heal_s=5.0)

    def __init__(self, expectation: Expectation) -> None:
        below, growth = expectation.get("below"), expectation.get("growth")
        self._below = float("inf") if below is None else float(below)
        self._growth = float("inf") if growth is None else float(growth)  # bytes in a second
        limits = [] if below is None else [f"is below {self._below / MIB:g} MB"]
        if growth is not None:
            limits.append(f"grows by less than {self._growth * 60 / MIB:.3g} MB in a minute")
        super().__init__(expectation, f"memory of {expectation.subject} {' and '.join(limits)}")

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        if (absent := self.absent(story)) is not None:
            return True, absent
        for name in self.running(story):
            row = story.row(name)
            size = None if row is None else row["uss_bytes"]
            if size is not None and size >= self._below:
                seen = f"{name} has {size / MIB:.1f} MB"
                return True, FaultFinding(seen=seen, value=size / MIB, unit="MB", processes=(name,))
            if (finding := self._grown(story, name)) is not None:
                return True, finding
        return True, None

    def _grown(self, story: Story, name: str) -> FaultFinding | None:
        series = [(at_s, rss) for at_s, _, rss in self.series(story, name, GROWTH_WINDOW_S) if rss]
        if len(series) < 3:
            return None
        least = min(size for _, size in series)
        last_s, last = series[-1]
        if last - least <= max(LEAST_GROWTH, self._growth * GROWTH_WINDOW_S):
            return None
        still = least + max(STILL_BYTES, STILL_PART * (last - least))
        begin_s, begin = next(one for one in reversed(series) if one[1] <= still)
        if last_s <= begin_s:  # rows that were answered late have one time
            return None
        grown, over_s = (last - begin) / MIB, last_s - begin_s
        return FaultFinding(
            seen=f"{name} has grown by {grown:.1f} MB in {over_s:.0f} s",
            value=grown / over_s * 60,
            unit="MB/min",
            processes=(name,),
            since_s=begin_s,
        )
