"""Reads which programs run, reports which of them have to be restarted; lines of JSON.

{"process": "robot_1-2", "argv": [...], "env": {...}, "cwd": null, "parameters": [...],
 "started_ns": 1763703001200000000}     it was started; the same with "launch": [...] for the
                                        launch file; {"forget": "robot_1-2"}

{"files": "robot_1-2", "paths": [...]}  what it has loaded
{"changed": [...], "processes": {"robot_1-2": ns}, "launch": false}
{"broken": "error: ...", "processes": [...]}
{"deleted": "...", "processes": [...]}
{"warning": "..."}
"""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Mapping
from typing import Any

from launcher.base import strict_json
from launcher.base.errors import LauncherError
from launcher.posix import dispositions
from launcher.run.watch.folders import QUIET_S, Folders, Settling
from launcher.run.watch.watched import Broken, Changed, Report, Watched
from launcher.run.watch.watched_programs import WatchedProgram

# All files are looked at so often: not every file system reports changes.
POLL_S = 2.0
POLL_ALONE_S = 0.5  # where the kernel cannot watch


class Watcher:
    """The loop: requests and changes in, reports out."""

    def __init__(self) -> None:
        self._wake = threading.Event()
        self._requests: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._watched = Watched()
        self._settling = Settling()
        self._folders = Folders(self._wake)
        self._poll_s = POLL_S
        self._next_poll_s = 0.0
        self._is_stale = True  # other folders may have to be watched

    def run(self) -> None:
        """Until the end of the input."""
        threading.Thread(target=self._read, daemon=True).start()
        while self._take_requests():
            self._wait()
            for report in self._watched.settled(
                self._settling.take(time.monotonic()), self._settling.busy
            ):
                send(_as_json(report))
                self._is_stale = True

    def _read(self) -> None:
        for line in sys.stdin:
            self._requests.put(line)
            self._wake.set()
        self._requests.put(None)
        self._wake.set()

    def _take_requests(self) -> bool:
        self._wake.clear()
        while not self._requests.empty():
            line = self._requests.get()
            if line is None:
                return False
            self._request(strict_json.unpacked(line))
        return True

    def _request(self, request: Mapping[str, Any]) -> None:
        self._is_stale = True
        if "forget" in request:
            self._watched.forget(request["forget"])
            return
        started_ns = request["started_ns"]
        if "launch" in request:
            changed = self._watched.add_launch(request["launch"], started_ns)
        else:
            name = request["process"]
            program = WatchedProgram(
                tuple(request["argv"]),
                request["env"],
                request["cwd"],
                tuple(request["parameters"]),
                members=tuple(map(tuple, request["members"])),
            )
            changed = self._watched.add_process(name, program, started_ns)
            send({"files": name, "paths": self._watched.files(name)})
        self._settling.note(changed, time.monotonic())

    def _wait(self) -> None:
        """Until something happens, or changes may be over."""
        if self._is_stale:
            self._watch_folders()
        now, due_s = time.monotonic(), self._settling.due_s
        if due_s is not None:
            self._wake.wait(max(0.0, due_s - now))
            self._look()
            return
        happened = self._folders.wait(min(self._poll_s, max(0.0, self._next_poll_s - now)))
        if happened or time.monotonic() >= self._next_poll_s:
            self._look()

    def _look(self) -> None:
        """Note what has changed, and when."""
        now, now_ns = time.monotonic(), time.time_ns()
        self._next_poll_s = now + self._poll_s
        self._is_stale = True  # folders may have been made again
        for path, changed_ns in self._watched.look().items():
            ago_s = (now_ns - changed_ns) / 1e9
            self._settling.note([path], now - ago_s if 0.0 < ago_s < QUIET_S else now)

    def _watch_folders(self) -> None:
        self._is_stale = False
        try:
            self._folders.watch(self._watched.paths)
        except LauncherError as error:
            if self._poll_s != POLL_ALONE_S:
                text = f"{error.message}; files are looked at every {POLL_ALONE_S:g} s instead"
                send({"warning": f"{text}\nhint: {error.hint}" if error.hint else text})
            self._poll_s = POLL_ALONE_S


def _as_json(report: Report) -> dict[str, Any]:
    if isinstance(report, Changed):
        return {
            "changed": report.paths,
            "processes": dict(report.processes),
            "launch": report.launch,
        }
    if isinstance(report, Broken):
        return {"broken": report.error.render(), "processes": report.processes}
    return {"deleted": report.path, "processes": report.processes}


def send(message: Mapping[str, Any]) -> None:
    sys.stdout.write(strict_json.packed(message) + "\n")
    sys.stdout.flush()


def main() -> int:
    dispositions.ignore()  # we end with our input
    try:
        Watcher().run()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    return 0


if __name__ == "__main__":
    sys.exit(main())
