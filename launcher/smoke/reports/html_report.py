"""`--html`: the page of a run as one file (`launcher.web.frozen`), with how it ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from launcher import __version__
from launcher.base import strict_json
from launcher.base.errors import ExitCode, LauncherError
from launcher.base.model.run_event import Entry
from launcher.smoke.observe.facts import LogLine
from launcher.smoke.reports import json_report, page_lines, page_processes
from launcher.smoke.reports.artifacts import save
from launcher.smoke.reports.moments import item, moment_s
from launcher.smoke.reports.result import SmokeResult
from launcher.web import assets
from launcher.web.frozen import FrozenRun, freeze
from launcher.web.graph_state import GraphState
from launcher.web.layout import Layout, render, source
from launcher.web.page_plan_tree import Tree, named, numbered

_OUTLINE = "launcher.launch.outline"
MAX_EVENTS = 20_000
RATE_S = 10.0  # before the stop
MESSAGES = 20  # the last ones of each topic
_PLAN = "plan.json"

Message = dict[str, Any]


def check() -> None:
    """LauncherError if files of the page are missing."""
    assets.libraries()


def write(path: Path, results: Sequence[SmokeResult], target: str, words: Sequence[str]) -> None:
    """One file for all runs; the first that failed is shown first. OSError.

    `words` name the launch file, its arguments, and how it is read; without them there is no tree.
    """
    tree: Tree | None = _planned(words) if words else None
    most = page_lines.MAX_LINES // len(results), page_lines.MAX_CHARACTERS // len(results)
    runs = [
        FrozenRun(label=f"run {number}: {_word(one)}", messages=messages(one, target, tree, most))
        for number, one in enumerate(results, 1)
    ]
    failed = [number for number, one in enumerate(results) if one.exit_code]
    title = f"{target}: {_word(results[failed[0] if failed else 0])}"
    chosen = failed[0] if failed else len(runs) - 1
    path.parent.mkdir(parents=True, exist_ok=True)
    save(path, freeze(runs, title=title, chosen=chosen))


def write_refusal(path: Path, error: LauncherError, target: str) -> None:
    """A page with the error, where nothing was run."""
    now = time.time()
    line = [None, "stderr", now, "ERROR", error.render()]
    run: Message = {"id": "", "pid": None, "target": target, "arguments": [], "started_wall_s": now}
    hello = _hello({**run, "log_dir": None, "domain_id": None}, now, None, "nothing was run")
    failure = {"title": "the run", "state": "failed", "wall": now, "detail": error.message}
    found = [
        hello,
        {"event": "lines", "first": 1, "lines": [line]},
        {"event": "expectations", "items": [failure]},
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    save(path, freeze([FrozenRun(label=target, messages=found)], title=f"{target}: not run"))


def messages(
    result: SmokeResult,
    target: str,
    tree: Tree | None = None,
    most: tuple[int, int] = (page_lines.MAX_LINES, page_lines.MAX_CHARACTERS),
) -> list[Message]:
    """What a page would have received of this run; `most`: lines and their characters."""
    facts, started_s = result.facts, result.started_s
    lines = facts.lines or tuple(LogLine(at_s=0.0, process=None, text=t) for t in result.last_lines)
    rows = page_lines.shortened(page_lines.rows_of(lines, started_s), *most)
    history = page_processes.history_of(facts, started_s)
    errors = page_lines.last_errors(rows)
    processes = page_processes.rows_of(result, errors, history["processes"])
    stop_s = started_s + facts.stop_s
    graph = _graph(result, processes, stop_s)
    found: list[Message | None] = [
        _hello(_run(result, target), started_s + facts.now_s, result, _word(result)),
        {"event": "processes", "wall": stop_s, "processes": processes},
        history,
        {"event": "run_events", "items": _events(result), "reset": True},
        {"event": "lines", "first": 1, "lines": rows},
        graph,
        *_messages(result, graph),
        _topics(result),
        _plan(result, tree),
        {"event": "expectations", "items": _expectations(result)},
    ]
    return [one for one in found if one is not None]


def _word(result: SmokeResult) -> str:
    if result.exit_code is ExitCode.OK:
        return "passed"
    return "interrupted" if result.interrupted else f"failed, exit code {int(result.exit_code)}"


# ---- the messages


def _hello(run: Message, ended: float, result: SmokeResult | None, text: str) -> Message:
    report = None if result is None else json_report.of_result(result)
    return {
        "event": "hello",
        "protocol": 1,
        "server": f"smoke-{run['id']}",
        "run": run,
        "launcher": __version__,
        "wall": ended,
        "read_only": True,
        "frozen": {"made": time.time(), "report": report},
        "ended": {"wall": ended, "how": "ended", "text": f"Smoke test: {text}."},
        "graph": {"available": True, "reason": None},
    }


def _run(result: SmokeResult, target: str) -> Message:
    last = result.last_state
    run = None if last is None else last.run
    given = [word for word in result.words[1:] if ":=" in word]
    return {
        "id": "" if run is None else run.run_id,
        "pid": None if run is None else run.pid,
        "target": target if run is None else run.target,
        "arguments": given if run is None else list(run.arguments),
        "started_wall_s": result.started_s if run is None else run.started_wall_s,
        "log_dir": None if run is None else run.log_dir,
        "domain_id": result.domain_id,
    }


def _events(result: SmokeResult) -> list[Message]:
    """The event log; samples of resources are in the history."""
    events = [one for one in result.facts.events if not one.event.is_sample]
    entries = [
        Entry(result.started_s + one.at_s, one.at_s, one.event, one.process, one.host)
        for one in events[-MAX_EVENTS:]
    ]
    return [{**entry.item, "text": entry.event.text} for entry in entries]


def _graph(result: SmokeResult, rows: Sequence[Message], wall_s: float) -> Message | None:
    """The last graph before the stop, with the nodes that had gone."""
    graphs = [] if result.last_state is None else result.last_state.graphs
    state = GraphState()
    for graph in graphs:
        state.take(graph, rows, float(graph.get("wall", wall_s)))
    document = state.document(rows, float(graphs[-1].get("wall", wall_s)) if graphs else wall_s)
    if document is None:
        return None
    layout = Layout()
    drawn = render(source(document))
    if drawn is None:
        return {**document, "positions": None}
    layout.take(document, drawn)
    return {**document, "positions": layout.positions()}


def _messages(result: SmokeResult, graph: Message | None) -> list[Message]:
    """The last messages of each topic that was watched."""
    types = {one["name"]: one["types"] for one in (graph or {}).get("topics", ())}
    found: list[Message] = []
    for topic in dict.fromkeys(message.topic for message in result.facts.messages):
        received = result.facts.received(topic)
        last = [one for one in received if one.watch == received[-1].watch][-MESSAGES:]
        for one in last:
            sent = None if one.sent_s is None else result.started_s + one.sent_s
            found.append(
                {
                    "event": "message",
                    "topic": topic,
                    "type": next(iter(types.get(topic, ())), None),
                    "wall": result.started_s + one.at_s,
                    "sent": sent,
                    "data": one.content,
                    "skipped": 0,
                }
            )
    return found


def _topics(result: SmokeResult) -> Message | None:
    """The rates before the stop of the topics whose messages were received."""
    facts, topics = result.facts, {}
    for topic in dict.fromkeys(message.topic for message in facts.messages):
        received = facts.received(topic)
        times = [one.at_s for one in received if one.watch == received[-1].watch]
        last = [at_s for at_s in times if facts.stop_s - RATE_S <= at_s <= facts.stop_s]
        span_s = last[-1] - last[0] if last else 0.0
        topics[topic] = {
            "rate_hz": (len(last) - 1) / span_s if span_s else 0.0,
            "bytes_per_s": None,
            "age_s": max(0.0, facts.stop_s - times[-1]),
            "count": len(times),
            "state": "subscribed",
            "error": None,
        }
    if not topics:
        return None
    return {"event": "topics", "wall": result.started_s + facts.stop_s, "topics": topics}


def _plan(result: SmokeResult, tree: Tree | None) -> Message | None:
    """What the launch file has done, from the files of the run."""
    try:
        plan: Message = strict_json.loads((result.folder / _PLAN).read_text(encoding="utf-8"))
        processes = numbered(plan["processes"])
    except (OSError, ValueError, KeyError, TypeError):
        return None  # it was killed before it wrote the file
    return {"event": "plan", **plan, "processes": processes, "tree": named(tree, processes)}


def _expectations(result: SmokeResult) -> list[Message]:
    facts = result.facts
    end_s = facts.stop_s if facts.ending is None else facts.ending.down_s
    found = []
    for one in () if result.exit_code is ExitCode.USAGE else result.judged:
        is_end = one.decided_s is None
        decided_s = end_s if one.decided_s is None else one.decided_s
        at_s = moment_s(one.verdict, decided_s, is_end=is_end)
        found.append(item(one.expectation, one.verdict, result.started_s + at_s))
    reasons = ["interrupted"] * bool(result.interrupted) + ["not ready in time"] * result.gave_up
    reasons += [result.trouble] if result.trouble else []
    if reasons:
        wall_s = result.started_s + end_s
        detail = "; ".join(reasons)
        found.append({"title": "the run", "state": "failed", "wall": wall_s, "detail": detail})
    return found


PLAN_S = 20.0  # a launch file that takes longer is launched without


def _planned(words: Sequence[str]) -> Any:
    """The outline of the launch file as JSON; None if there is none, or it takes too long."""
    with subprocess.Popen(
        [sys.executable, "-m", _OUTLINE, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        try:
            return strict_json.unpacked(process.communicate(timeout=PLAN_S)[0])
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # its pid is valid until it is waited for
            return None
        except ValueError:
            return None
