"""`wait` for the processes of a run."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time

import psutil
import pytest

from tests.support.benches import ControlBench
from tests.support.json_forms import fit
from tests.support.waiting import wait_until

TIMEOUT_S = 60.0
CAT = 'sh("exec cat", name="cat")'
# One is ready when the file `go` is there.
LATE = (
    'sh("until test -e go; do sleep 0.02; done; echo I am ready; exec cat", name="late", cwd={!r})'
)


def start(bench: ControlBench, *words: str, timeout_s: float = TIMEOUT_S) -> subprocess.Popen[str]:
    runtime = str(bench.runtime)
    return subprocess.Popen(
        [sys.executable, "-m", "launcher", "wait", *words, "--timeout", str(timeout_s)],
        env={**bench.env, "TMPDIR": runtime, "XDG_RUNTIME_DIR": runtime},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def end(waiting: subprocess.Popen[str]) -> tuple[int, str, str]:
    out, err = waiting.communicate(timeout=2 * TIMEOUT_S)
    return waiting.returncode, out, err


def follows(process: subprocess.Popen[str]) -> bool:
    """Whether it has its two connections to the run."""
    return len(psutil.Process(process.pid).net_connections("unix")) >= 2


def test_a_run_may_begin_later(control_bench: ControlBench):
    waiting = start(control_bench, "cat")
    with control_bench.launch(CAT):
        code, out, err = end(waiting)
    assert (code, err) == (0, "")
    assert out.startswith("cat-1 is running (")


def test_ready_is_what_the_supervision_file_says(control_bench: ControlBench):
    folder = control_bench.folder
    rules = 'late: {ready_when: {log: "I am ready"}}\n'
    (folder / "bench.supervise.yaml").write_text(rules, encoding="utf-8")
    with control_bench.launch(LATE.format(str(folder))) as run:
        done = run.shell("wait", "late")
        assert (done.returncode, done.stderr) == (0, "")  # it runs
        late = run.shell("wait", "late", "--state", "ready", "--timeout", "0.1")
        assert late.returncode == 124
        assert "late-1 is running: no line with 'I am ready'" in late.stderr
        waiting = start(control_bench, "late", "--state", "ready")
        (folder / "go").touch()
        code, out, _ = end(waiting)
        assert code == 0
        assert out.startswith("late-1 is ready (")


def test_a_process_that_has_ended_runs_no_more(control_bench: ControlBench):
    with control_bench.launch(f'{CAT}, sh("exit 3", name="brief")') as run:
        ended = run.shell("wait", "brief", "--state", "ended", "--timeout", "60")
        assert ended.returncode == 0
        assert ended.stdout.startswith("brief-2 has ended (exit code 3)")
        lost = run.shell("wait", "cat", "brief", "--timeout", "60")
        assert (lost.returncode, lost.stderr) == (1, "error: brief-2 has ended (exit code 3)\n")


def test_the_end_of_a_run_ends_what_waits(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        assert run.shell("wait", "cat").returncode == 0
        over = start(control_bench, "cat", "--state", "ended")
        never = start(control_bench, "dog")
        wait_until(lambda: follows(over) and follows(never), "both wait")
        run.shell("quit")
        code, out, _ = end(over)
        # Its exit, or the end of the run, whichever is read first.
        assert code == 0
        assert re.match(r"cat-1 has ended \(|cat has ended with its run \(", out)
        assert end(never) == (1, "", "error: the run has ended without a process 'dog'\n")


def test_before_the_run_all_conditions_are_named(control_bench: ControlBench):
    waiting = start(control_bench, "cat", "--topic", "late", "--json", timeout_s=0.5)
    code, out, err = end(waiting)
    assert code == 124
    texts = [one["text"] for one in json.loads(out)["conditions"]]
    assert texts == [
        "no run has a process 'cat' yet",
        "publisher /late: the domain is that of the run: no run yet",
    ]
    assert all(text in err for text in texts)


def test_what_is_missing_at_the_timeout(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        assert run.shell("wait", "cat").returncode == 0
        late = run.shell("wait", "cat", "cta", "--timeout", "0.2", "--json")
        assert late.returncode == 124
        unknown = "unknown process 'cta' (did you mean 'cat-1'?"
        assert late.stderr.startswith(f"note: {unknown}")
        assert f"not within 0.2 s: {unknown}" in late.stderr
        fit("wait", late.stdout)
        begun_s = time.monotonic()
        assert run.shell("wait", "cat", "--timeout", "60").returncode == 0
        assert time.monotonic() - begun_s < 60


@pytest.mark.parametrize(
    "words",
    [(), ("--state", "ready"), ("cat", "--state", "up"), ("--topic", ""), ("--topic", "a b")],
    ids=str,
)
def test_bad_command_lines(control_bench: ControlBench, words):
    code, _, err = end(start(control_bench, *words))
    assert code == 2
    assert re.search("wait|behind --topic is missing|running, ready, ended|cannot be the name", err)
