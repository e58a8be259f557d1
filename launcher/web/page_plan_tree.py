"""The tree of a run's launch file, which a separate process evaluates again."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sys
from collections import defaultdict, deque
from collections.abc import Sequence
from typing import Any

from launcher.base import strict_json
from launcher.posix.cleanup import RUN_ID_VARIABLE

EVALUATION_S = 20.0
_COMMAND = ("-m", "launcher.launch.outline")

Tree = list[dict[str, Any]]


async def read_tree(target: str, arguments: Sequence[str]) -> Tree | None:
    """The tree of the message `plan`; None if the launch file cannot be evaluated."""
    env = {name: value for name, value in os.environ.items() if name != RUN_ID_VARIABLE}
    try:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, *_COMMAND, target, *arguments),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
            env=env,
            start_new_session=True,
        )
    except OSError:
        return None
    try:
        output, _ = await asyncio.wait_for(process.communicate(), EVALUATION_S)
        tree: Tree = strict_json.unpacked(output)
    except (TimeoutError, asyncio.TimeoutError, ValueError):
        return None
    finally:
        if process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    return tree


def numbered(processes: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The processes of a plan document with their names, whose numbers count those of the run."""
    return [{**one, "name": f"{one['label']}-{i}"} for i, one in enumerate(processes, 1)]


def named(tree: Tree | None, processes: Sequence[dict[str, Any]]) -> Tree | None:
    """The tree with the names that the processes have in the run; null for one not started.

    Their numbers differ where the run has started them in another order. `processes` are those
    of the message `plan`.
    """
    if tree is None:
        return None
    started: defaultdict[str, deque[str]] = defaultdict(deque)
    for process in processes:
        started[process["label"]].append(process["name"])
    names: dict[str, str | None] = {}
    for planned in sorted(_names(tree), key=_number):
        waiting = started[planned.rpartition("-")[0]]
        names[planned] = waiting.popleft() if waiting else None
    return [_renamed(entry, names) for entry in tree]


def _names(tree: Tree) -> set[str]:
    found = {entry["name"] for entry in tree if entry["name"] is not None}
    return found.union(*(_names(entry["children"]) for entry in tree))


def _number(name: str) -> int:
    number = name.rpartition("-")[2]
    return int(number) if number.isdecimal() else 0


def _renamed(entry: dict[str, Any], names: dict[str, str | None]) -> dict[str, Any]:
    name = None if entry["name"] is None else names[entry["name"]]
    children = [_renamed(child, names) for child in entry["children"]]
    return {**entry, "name": name, "text": name or entry["text"], "children": children}
