"""Runs colcon as a separate process, which reports what happens in lines of JSON.

Its arguments are EVENTS LIFE WORD ... The words are colcon's. EVENTS is a descriptor for the events
of `Colcon.events`. LIFE is the read end of a pipe into which nobody writes: if it is closed, the
launcher has ended, and all descendants are killed.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from typing import Any

from launcher.base import strict_json
from launcher.workspace.building.colcon import descendants


def main() -> int:
    events, life = int(sys.argv[1]), int(sys.argv[2])
    descendants.adopt()
    for descriptor in (events, life):
        os.set_inheritable(descriptor, False)
    threading.Thread(target=_end_with_the_launcher, args=(life,), daemon=True).start()
    from colcon_core import executor
    from colcon_core.command import main as colcon

    _observe(executor, os.fdopen(events, "w", encoding="utf-8", buffering=1).write)
    return int(colcon(command_name="colcon", argv=sys.argv[3:]) or 0)


def _end_with_the_launcher(life: int) -> None:
    os.read(life, 1)
    descendants.kill()
    os._exit(1)


def _observe(executor: Any, write: Callable[[str], object]) -> None:
    """Let every event reactor that colcon makes pass its events on."""
    create = executor.create_event_reactor

    def create_observed(context: object) -> Any:
        reactor = create(context)
        reactor.register_observer(_Observer(write))
        return reactor

    executor.create_event_reactor = create_observed


class _Observer:
    EVENT_HANDLER_NAME = "launcher"

    def __init__(self, write: Callable[[str], object]) -> None:
        self._write = write

    def __call__(self, event: tuple[Any, Any]) -> None:
        data, context = event
        kind = type(data).__name__
        if kind == "TimerEvent":
            return
        entry: dict[str, Any] = {"kind": kind, "package": getattr(context, "identifier", context)}
        if kind in ("StdoutLine", "StderrLine"):
            line = data.line
            text = line.decode(errors="replace") if isinstance(line, bytes) else line
            entry["text"] = text.rstrip("\n")
        elif kind == "JobProgress":
            entry["text"] = data.progress
        elif kind == "JobEnded":
            entry["code"] = data.rc if isinstance(data.rc, int) else 1
        elif not kind.startswith("Job"):
            return
        if kind.startswith("Job"):
            entry["package"] = data.identifier
        self._write(strict_json.packed(entry) + "\n")
