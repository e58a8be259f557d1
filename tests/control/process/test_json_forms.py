"""The forms of verbs about a run, on a real one."""

from __future__ import annotations

import json
from typing import Any

import pytest

from launcher.posix.json_output import json_line
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.json_forms import fit
from tests.support.waiting import wait_until

ACTIONS = 'sh("exec cat", name="cat"), sh("exit 3", name="brief")'
# In this order: what ends a process comes last.
REQUESTS: dict[str, dict[str, Any]] = {
    "ps": {"responsive": True},
    "info": {},
    "mute": {},
    "unmute": {},
    "solo": {},
    "level": {"level": "WARN"},
    "grep": {"pattern": "x"},
    "show": {},
    "format": {},
    "send": {"text": "a line"},
    "pause": {},
    "resume": {},
    "stack": {},
    "watch": {},
    "reload": {"dry_run": True},
    "restart": {},
    "kill": {},
    "start": {},
    "stop": {},
}
UNNAMED = ("format", "reload", "show")
STREAMS = ("top", "logs", "events")


def answers(run: ControlledRun, verb: str, **options: Any) -> str:
    """What `verb --json` prints: the result of the socket, with a version."""
    names = () if verb in UNNAMED else ("cat",)
    return json_line(run.ask(verb, *names, **options))


def stream(run: ControlledRun, verb: str) -> str:
    with run.connect() as connection:
        for item in connection.follow(verb, ()):
            return json_line(item)
    raise AssertionError(f"{verb} sent nothing")


def test_the_forms_of_answers_and_streams(control_bench: ControlBench):
    with control_bench.launch(ACTIONS) as run:
        wait_until(lambda: run.row("brief")["last_exit"], "an exit")
        run.ask("send", "cat", text="a line")
        run.wait_for_log("cat", "a line")
        for verb, options in REQUESTS.items():
            fit(verb, answers(run, verb, **options))
        for verb in STREAMS:
            fit(verb, stream(run, verb))


@pytest.mark.thorough
def test_the_forms_that_a_shell_prints(control_bench: ControlBench):
    with control_bench.launch(ACTIONS) as run:
        run.ask("send", "cat", text="a line")
        run.wait_for_log("cat", "a line")
        words = {"runs": (), "ps": (), "info": ("cat",), "plan": (), "logs": ("cat",), "events": ()}
        for verb, more in words.items():
            fit(verb, run.shell(verb, *more, "--json").stdout)
        fit("plan --diff", run.shell("plan", "--diff", "--json").stdout)
        fit("restart", run.shell("restart", "cat", "--json").stdout)
        followers = {one: run.shell_start(one, "-f", "--json") for one in ("events", "logs", "top")}
        heads = {one: follower.stdout.readline() for one, follower in followers.items()}
        fit("quit", run.shell("quit", "--json").stdout)
        for verb, follower in followers.items():
            fit(verb, heads[verb] + follower.communicate(timeout=60)[0])
            assert follower.returncode == 0
    assert json.loads(run.shell("runs", "--json").stdout) == {"version": 1, "runs": []}
