"""Resources of the units on a host, read from its /proc by the shell.

Every 3 s the shell reads a stat file for each process of a unit; grep reads the USS of all of them
at once, when a unit is new and every 10 s, since the kernel walks all pages for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from launcher.base.model.record import as_dict
from launcher.run.monitor.resources import USS_EVERY_S, Reading, summed

# Field numbers of /proc/PID/stat behind the name, which may have blanks.
_UTIME, _STIME, _THREADS, _RSS = 11, 12, 17, 21
NEW_S = 5.0  # the memory of a new process grows while it loads what it needs

# A process of which no unit is known counts alone. With version 1 of control groups, that of the
# unit may be in the hierarchy of systemd alone, although there is one of version 2. If the main
# thread of a process has ended before others, another one shows its memory and files.
_SCRIPT = """
ticks=$(getconf CLK_TCK 2>/dev/null) || ticks=100
page=$(getconf PAGESIZE 2>/dev/null) || page=4096
read -r up _ </proc/uptime
echo "units $ticks $page $up"
files=
for pid in {pids}; do
  unit= members=$pid
  while IFS=: read -r _ kind path; do
    case $kind:$path in :*.service|name=systemd:*.service) unit=$path ;; esac
  done <"/proc/$pid/cgroup"
  for root in /sys/fs/cgroup /sys/fs/cgroup/systemd /sys/fs/cgroup/unified; do
    [ -n "$unit" ] && [ -r "$root$unit/cgroup.procs" ] || continue
    while read -r member; do
      [ "$member" = "$pid" ] || members="$members $member"
    done <"$root$unit/cgroup.procs"
    break
  done
  for member in $members; do
    folder=/proc/$member
    read -r line <"$folder/stat" || continue
    case ${{line##*) }} in Z*)
      for task in "$folder/task/"*; do
        read -r line <"/proc/${{task##*/}}/stat" || continue
        case ${{line##*) }} in Z*) ;; *) folder=$task; break ;; esac
      done ;;
    esac
    set -- "$folder/fd/"*
    echo "process $pid $member $# ${{line##*) }}"
    files="$files $folder/smaps_rollup"
  done
done 2>/dev/null
"""
_MEMORY = '[ -z "$files" ] || grep -H "^Private_" $files 2>/dev/null || :\n'


class Samples:
    """Samples of units by the pids of their main processes; CPU time since the last one.

    Times between samples are those of the host: answers may come late, and two at a time.
    """

    def __init__(self) -> None:
        self._since: dict[int, float] = {}  # main process -> when it was seen first
        self._read_s: dict[int, float] = {}  # main process -> when it was read last, there
        self._cpu_s: dict[int, float] = {}  # any process -> its CPU time then
        self._uss: dict[int, int] = {}
        self._uss_s = float("-inf")

    def script(self, pids: Iterable[int], now: float) -> str:
        """Prints what `read` takes."""
        pids = list(pids)
        is_new = any(now - self._since.get(pid, now) < NEW_S for pid in pids)
        text = _SCRIPT.format(pids=" ".join(map(str, pids)))
        if not is_new and now - self._uss_s < USS_EVERY_S:
            return text
        self._uss_s = now
        return text + _MEMORY

    def read(self, text: str, pids: Mapping[int, int], now: float) -> dict[int, Mapping[str, Any]]:
        """By process id, for pids by process id; what cannot be read is left out."""
        lines = [line.split() for line in text.splitlines()]
        units = next((line[1:] for line in lines if line[:1] == ["units"]), None)
        if units is None:
            return {}
        ticks, page, up_s = int(units[0]), int(units[1]), float(units[2])
        members: dict[int, dict[int, list[str]]] = {}
        for line in lines:
            if line[:1] == ["process"] and len(line) > _RSS + 4:
                members.setdefault(int(line[1]), {})[int(line[2])] = line[3:]
        self._uss.update(_private(lines))
        ids = {pid: process_id for process_id, pid in pids.items()}
        found: dict[int, Mapping[str, Any]] = {}
        cpu_s: dict[int, float] = {}
        for pid, of_unit in members.items():
            readings = list(self._readings(pid, of_unit, ticks, page, cpu_s))
            if pid in ids:
                sample = summed(pid, readings, up_s - self._read_s.get(pid, up_s))
                found[ids[pid]] = as_dict(sample)
        self._cpu_s = cpu_s
        self._uss = {pid: size for pid, size in self._uss.items() if pid in cpu_s}
        self._since = {pid: self._since.get(pid, now) for pid in members}
        self._read_s = dict.fromkeys(members, up_s)
        return found

    def _readings(
        self,
        main: int,
        members: Mapping[int, list[str]],
        ticks: int,
        page: int,
        cpu: dict[int, float],
    ) -> Iterator[Reading]:
        for pid, (fds, *fields) in members.items():
            cpu[pid] = (int(fields[_UTIME]) + int(fields[_STIME])) / ticks
            yield Reading(
                # A process that is new in a known unit was started after the last sample.
                cpu_s=cpu[pid] - self._cpu_s.get(pid, 0.0),
                rss_bytes=int(fields[_RSS]) * page,
                uss_bytes=self._uss.get(pid, 0) if main in self._uss else None,
                threads=int(fields[_THREADS]),
                fds=int(fds),
            )


def _private(lines: Iterable[list[str]]) -> dict[int, int]:
    """USS by pid, from lines as `/proc/7/smaps_rollup:Private_Dirty: 12 kB`."""
    found: dict[int, int] = {}
    for line in lines:
        if line and line[0].startswith("/proc/"):
            pid = int(line[0].split("/")[2])
            found[pid] = found.get(pid, 0) + 1024 * int(line[1])
    return found
