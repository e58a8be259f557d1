"""In place of `launcher.faults.watcher`: reports what a test writes into a file, line by line.

Acknowledges, mutes and unmutes on request, as the watcher does.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

FILE = "FAULT_REPORTS"  # the variable with its path
# For a launch file: an expression that makes the run start this module.
IN_PLACE = (
    '*(setattr(__import__("launcher.faults.fault_watch", fromlist=["MODULE"]), "MODULE", '
    f'"{__name__}") or ()),'
)


class Reports:
    """The file, as a test sees it; `env` is for the launcher."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / "reports"
        self._path.touch()
        self.env = {FILE: str(self._path)}

    def write(self, report: dict[str, Any]) -> None:
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(report) + "\n")

    @staticmethod
    def now() -> float:
        return time.time()

    def fault(self, change: str, **fields: Any) -> dict[str, Any]:
        """Report a change of a fault with these fields; it."""
        made = fault(**fields)
        self.write({"fault": made, "change": change})
        return made


def fault(name: str = "robot_1 reports", **fields: Any) -> dict[str, Any]:
    """An active fault, as docs/reference/faults.md has it."""
    return {
        "fault": name,
        "expectation": name,
        "kind": "rate",
        "place": "system.expect.yaml:12",
        "state": "active",
        "expected": "at least 4 Hz",
        "seen": "no message for 3.0 s",
        "value": 0.0,
        "unit": "Hz",
        "first_s": time.time() - 5,
        "confirmed_s": time.time() - 4,
        "last_s": time.time(),
        "healed_s": None,
        "count": 1,
        "lines": ["[robot_1] killed"],
        "message": None,
        "processes": ["cat-1"],
        "topics": ["/fleet/status"],
        "nodes": ["/fleet/robot_1"],
        "cause": "cat-1 was killed (SIGKILL)",
        "rule": "dead publisher",
        "follows": None,
        "incident": 1,
        "acknowledged": None,
        "muted": None,
        **fields,
    }


def _say(report: dict[str, Any]) -> None:
    print(json.dumps(report), flush=True)


def _answer(faults: dict[str, dict[str, Any]], mutes: dict[str, dict[str, Any]]) -> None:
    for line in sys.stdin:
        request = json.loads(line)
        if request["do"] not in ("acknowledge", "mute", "unmute"):
            continue
        reason, for_s = request["reason"], request["for_s"]
        if request["fault"] not in faults:  # muted before it was seen
            mutes.pop(request["fault"], None)
            if request["do"] == "mute":
                until_s = None if for_s is None else request["wall_s"] + for_s
                mutes[request["fault"]] = {"reason": reason, "until_s": until_s}
            _say({"mutes": mutes, "id": request["id"]})
            continue
        changed = faults[request["fault"]]
        if request["do"] == "acknowledge":
            changed["acknowledged"] = {"wall_s": request["wall_s"], "reason": reason}
        else:
            until_s = None if for_s is None else request["wall_s"] + for_s
            is_muted = request["do"] == "mute"
            changed["muted"] = {"reason": reason, "until_s": until_s} if is_muted else None
        _say({"fault": changed, "change": "updated", "id": request["id"]})
    os._exit(0)


def main() -> None:
    faults: dict[str, dict[str, Any]] = {}
    mutes: dict[str, dict[str, Any]] = {}
    threading.Thread(target=_answer, args=(faults, mutes), daemon=True).start()
    beat_s = 0.0
    with open(os.environ[FILE], encoding="utf-8") as file:
        while True:
            if time.monotonic() >= beat_s:
                beat_s = time.monotonic() + 2.0
                _say({"alive": True})
            if line := file.readline():
                report = json.loads(line)
                mutes.update(report.get("mutes", {}))
                if "fault" in report:
                    faults[report["fault"]["fault"]] = report["fault"]
                _say(report)
            else:
                time.sleep(0.02)


if __name__ == "__main__":
    main()
