"""Two processes of a bench, one of which waits until the other is ready."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from tests.support.controlled_run import ControlledRun

if TYPE_CHECKING:
    from tests.support.benches import Bench

# `server` is ready when the file `go` is there; `worker` waits for that.
PAIR = (
    'sh("touch worker_ran; exec sleep 60", name="worker", cwd={cwd!r}),'
    'sh("until test -e go; do sleep 0.02; done; echo server is ready; exec sleep 60", '
    'name="server", cwd={cwd!r}),'
)


def supervise(bench: Bench, text: str) -> None:
    (bench.folder / "bench.supervise.yaml").write_text(text, encoding="utf-8")


def supervise_by(bench: Bench, command: str) -> None:
    """The server is ready when a command succeeds."""
    text = f"server: {{ready_when: {{command: {command}}}}}\nworker: {{after: server}}\n"
    supervise(bench, text)


def pair(bench: Bench) -> str:
    return PAIR.format(cwd=str(bench.folder))


def events(bench: Bench) -> list[dict[str, Any]]:
    file = bench.folder / "log" / "latest" / "events.jsonl"
    if not file.exists():
        return []
    whole, _, _ = file.read_text().rpartition("\n")  # what is behind it is just being written
    return [json.loads(line) for line in whole.splitlines()]


def moments(bench: Bench) -> list[tuple[str, str]]:
    """(event, label of the process) of what is about starts, in order."""
    kinds = ("waiting", "released", "ready", "started", "ended", "not started", "withdrawn")
    return [
        (event["event"], event["process"].rpartition("-")[0])
        for event in events(bench)
        if event["event"] in kinds and "process" in event
    ]


def waits(run: ControlledRun, name: str) -> bool:
    return bool(run.row(name)["waiting_for"])


def go(bench: Bench) -> None:
    (bench.folder / "go").touch()
