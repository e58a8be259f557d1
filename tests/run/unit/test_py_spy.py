"""What py-spy prints, and what is told of its failures."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from launcher.posix import proc
from launcher.run.stacks import py_spy
from launcher.run.stacks.dump import document, lines
from launcher.run.stacks.py_spy import Completed

FRAME = {"name": "spin", "filename": "/opt/arm.py", "line": 7, "locals": None}


def thread(tid: int, **more: object) -> dict[str, object]:
    usual = {"os_thread_id": tid, "thread_name": "t", "active": True, "owns_gil": False}
    return {**usual, "frames": [FRAME], **more}


def test_threads_are_in_order_the_main_thread_first():
    output = json.dumps([thread(9), thread(8, thread_name=None, frames=[]), thread(7)]).encode()
    dump = py_spy.parse(8, output)
    assert [one.tid for one in dump.threads] == [8, 7, 9]
    assert dump.place == ""
    assert py_spy.parse(9, output).place == "spin (/opt/arm.py:7)"


def test_the_text_has_states_and_local_variables_without_control_characters():
    frame = {**FRAME, "locals": [{"name": "a", "repr": "'\x1b[2J\n'"}]}
    found = [thread(7, owns_gil=True, active=True, frames=[frame])]
    dump = py_spy.parse(7, json.dumps(found).encode())
    _, head, place, variable = lines(dump)
    assert head == "  thread 7 t (active, holds the GIL)"
    assert place == "    spin (/opt/arm.py:7)"
    assert "\x1b" not in variable
    json.dumps(document(dump))


@pytest.mark.parametrize("output", ["", "{", "{}x", "[1]", '[{"active": 1}]', "null"])
def test_output_that_is_no_dump(output: str):
    with pytest.raises(ValueError, match="unknown output of py-spy"):
        py_spy.parse(7, output.encode())


ERRORS = """Error: Failed to get stack traces

Caused by:
    0: Failed to suspend process
    1: unexpected waitpid result

Stack backtrace:
   0: anyhow::error
"""
CAUSES = "Failed to suspend process: unexpected waitpid result"


@pytest.mark.parametrize(
    ("errors", "code", "says"),
    [
        (ERRORS, 1, f"py-spy: Failed to get stack traces: {CAUSES}"),
        ("Error: Bad address (os error 14)\n", 1, "py-spy: Bad address (os error 14)"),
        ("", 1, "py-spy: no message"),
        ("", None, "py-spy did not end in time"),
    ],
)  # fmt: skip
def test_failures_are_told_in_its_own_words(errors, code, says):
    assert py_spy.failure(Completed(code, b"", errors.encode())) == says


@pytest.mark.parametrize(
    ("scope", "says", "hint"),
    [
        (None, "capability SYS_PTRACE", "--cap-add SYS_PTRACE"),
        ("0", "capability SYS_PTRACE", "--cap-add SYS_PTRACE"),
        ("1", "kernel.yama.ptrace_scope is 1", "sudo sysctl kernel.yama.ptrace_scope=0"),
        ("2", "kernel.yama.ptrace_scope is 2", "sudo setcap cap_sys_ptrace=eip"),
        ("3", "kernel.yama.ptrace_scope is 3", "until the next boot"),
    ],
)
def test_what_the_kernel_forbids_is_told_with_its_repair(
    tmp_path: Path, monkeypatch, scope, says, hint
):
    (tmp_path / "7").mkdir()
    rule = tmp_path / "sys/kernel/yama/ptrace_scope"
    rule.parent.mkdir(parents=True)
    if scope is not None:
        rule.write_text(f"{scope}\n")
    monkeypatch.setattr(proc, "ROOT", str(tmp_path))
    problem, repair = py_spy.repair(7, "/opt/py-spy")
    assert says in problem
    assert hint in repair
    owner = os.stat(tmp_path / "7").st_uid
    monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    problem, repair = py_spy.repair(7, "/opt/py-spy")
    assert (problem.endswith(f"belongs to user {owner}"), repair) == (
        True,
        "sudo /opt/py-spy dump --pid 7",
    )


def test_where_py_spy_is(monkeypatch):
    monkeypatch.setenv(py_spy.VARIABLE, "/opt/py-spy")
    assert py_spy.find() == "/opt/py-spy"
    monkeypatch.setenv(py_spy.VARIABLE, "")
    assert py_spy.find() is None
    monkeypatch.delenv(py_spy.VARIABLE)
    assert os.path.basename(py_spy.find() or "") == "py-spy"
