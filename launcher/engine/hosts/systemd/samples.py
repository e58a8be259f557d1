"""Resources of the processes on a host, read from its /proc by the shell."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from typing import Any

# Field numbers of /proc/PID/stat behind the name, which may have blanks.
_UTIME, _STIME, _THREADS, _RSS = 11, 12, 17, 21


def script(pids: Iterable[int]) -> str:
    """Prints a line for each process that exists; starts no other program but getconf."""
    numbers = " ".join(map(str, pids))
    return f"""
echo "units $(getconf CLK_TCK) $(getconf PAGESIZE)"
for pid in {numbers}; do
  read -r line <"/proc/$pid/stat" || continue
  set -- "/proc/$pid/fd/"*
  echo "$pid $# ${{line##*) }}"
done 2>/dev/null"""


class Samples:
    """Makes samples of the main process of each unit; CPU time since the last one."""

    def __init__(self) -> None:
        self._before: dict[int, tuple[int, float, float]] = {}

    def read(self, text: str, pids: Mapping[int, int], now: float) -> dict[int, Mapping[str, Any]]:
        """By process id, for pids by process id; what cannot be read is left out."""
        lines = [line.split() for line in text.splitlines()]
        units = next((line for line in lines if line[:1] == ["units"]), ["units", "100", "4096"])
        ticks, page = int(units[1]), int(units[2])
        by_pid = {line[0]: line for line in lines if len(line) > _RSS + 2}
        found = {}
        for process_id, pid in pids.items():
            if str(pid) in by_pid:
                found[process_id] = self._one(process_id, by_pid[str(pid)], ticks, page, now)
        return found

    def _one(
        self, process_id: int, line: list[str], ticks: int, page: int, now: float
    ) -> Mapping[str, Any]:
        pid, fds, fields = int(line[0]), int(line[1]), line[2:]
        cpu_s = (int(fields[_UTIME]) + int(fields[_STIME])) / ticks
        before = self._before.get(process_id)
        self._before[process_id] = pid, cpu_s, now
        percent = None
        if before is not None and before[0] == pid and now > before[2]:
            percent = 100.0 * (cpu_s - before[1]) / (now - before[2])
        return {
            "pid": pid,
            "cpu_percent": percent,
            "rss_bytes": int(fields[_RSS]) * page,
            "uss_bytes": None,
            "threads": int(fields[_THREADS]),
            "fds": fds,
            "processes": 1,
        }
