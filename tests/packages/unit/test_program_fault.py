"""Why a program cannot be executed: the reason, and that the system refuses it, too."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.packages import program_fault
from launcher.packages.program_fault import fault_of


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def program(path: str, content: bytes, mode: int = 0o755) -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_bytes(content)
    Path(path).chmod(mode)


def elf(machine: int) -> bytes:
    """The beginning of a program for a machine."""
    head = b"\x7fELF\x02\x01\x01" + bytes(9) + b"\x02\0"
    return head + machine.to_bytes(2, "little") + bytes(99)


SCRIPT = b"#!/bin/sh\n"
OTHER = 183 if os.uname().machine == "x86_64" else 62
FAULTY: dict[str, tuple[Callable[[], object], str, str | None]] = {
    "no bit": (lambda: program("x", SCRIPT, 0o644), "'./x' is not executable", "chmod +x ./x"),
    "no bit, no line": (
        lambda: program("x.py", b"print(1)\n", 0o644),
        "'./x.py' is not executable",
        "chmod +x ./x.py, and write '#!/usr/bin/env python3' into its first line",
    ),
    "no line": (
        lambda: program("x.py", b"print(1)\n"),
        "'./x.py' does not begin with a '#!' line",
        "write '#!/usr/bin/env python3' into its first line",
    ),
    "no line of a shell": (
        lambda: program("x", b"echo\n"),
        "'./x' does not begin with a '#!' line",
        "write '#!/bin/sh' into its first line",
    ),
    "windows": (
        lambda: program("x", b"#!/bin/sh\r\necho\r\n"),
        "the '#!' line of './x' ends with a carriage return (CRLF)",
        r"sed -i 's/\r$//' ./x",
    ),
    "windows, env": (
        lambda: program("x", b"#!/usr/bin/env sh\r\necho\r\n"),
        "the '#!' line of './x' ends with a carriage return (CRLF)",
        r"sed -i 's/\r$//' ./x",
    ),
    "mark": (
        lambda: program("x", b"\xef\xbb\xbf#!/bin/sh\n"),
        "'./x' has a byte order mark in front of its '#!'",
        "save it as UTF-8 without one",
    ),
    "interpreter": (
        lambda: program("x", b"#!/no/such/sh -e\n"),
        "the '#!' line of './x' names '/no/such/sh', which does not exist",
        None,
    ),
    "interpreter, no bit": (
        lambda: (program("sh", SCRIPT, 0o644), program("x", b"#!./sh\n")),
        "the '#!' line of './x' names './sh', which is not executable",
        None,
    ),
    "env": (
        lambda: program("x", b"#!/usr/bin/env python9\n"),
        "the '#!' line of './x' asks for 'python9', which is not in PATH",
        None,
    ),
    "empty line": (
        lambda: program("x", b"#! \n"),
        "the '#!' line of './x' names no interpreter",
        None,
    ),
    "empty": (lambda: program("x", b""), "'./x' is empty", None),
    "bytes": (lambda: program("x", bytes(300)), "'./x' is no program of this machine", None),
    "machine": (lambda: program("x", elf(OTHER)), "'./x' is for ", None),
    "folder": (lambda: os.mkdir("x"), "'./x' is a folder, not a program", None),
    "link": (
        lambda: os.symlink("gone", "x"),
        "'./x' is a link to 'gone', which does not exist",
        None,
    ),
    "absent": (lambda: None, "there is no './x' in the working directory", None),
    "absent, similar": (
        lambda: program("talker.py", SCRIPT),
        "there is no './talkr.py' in the working directory",
        "did you mean 'talker.py'?",
    ),
    "absent, below": (
        lambda: program("scripts/x", SCRIPT),
        "there is no './x' in the working directory",
        "there is one in another folder: 'scripts/x'",
    ),
}


def is_refused(word: str) -> bool:
    """Whether the system executes it no further than its interpreter."""
    try:
        return subprocess.run([word], stderr=subprocess.DEVNULL, timeout=60).returncode == 127
    except OSError:
        return True


@pytest.mark.parametrize("name", FAULTY)
def test_what_the_system_refuses_is_explained(name: str, monkeypatch: pytest.MonkeyPatch):
    # The kernel of this machine may have handlers for other formats.
    is_other = program_fault._handlers() and name in ("bytes", "machine")
    monkeypatch.setattr(program_fault, "_BINFMT", "/no/such/folder")
    make, text, hint = FAULTY[name]
    make()
    word = next(one for one in ("./talkr.py", "./x.py", "./x") if one in text)
    fault = fault_of(word, os.environ)
    assert fault is not None
    assert fault.text.startswith(text)
    assert fault.hint == hint
    assert is_other or is_refused(word)


SOUND = {
    "elf": "/bin/true",
    "path": "true",
    "shell": "./a.sh",
    "env": "./b.py",
    "options": "./c.py",
    "deep": "sub/d",
}


@pytest.mark.parametrize("name", SOUND)
def test_what_can_be_executed_has_no_fault(name: str):
    program("a.sh", b"#! /bin/sh -e\nexit 0\n")
    program("b.py", b"#!/usr/bin/env python3\n")
    program("c.py", f"#!{sys.executable} -E\n".encode())
    program("sub/d", b"#!/usr/bin/env -S sh -e\n")
    assert fault_of(SOUND[name], os.environ) is None
    assert not is_refused(SOUND[name])


def test_a_program_is_searched_in_the_path_of_its_process(folder: Path):
    program("bin/tool", SCRIPT, 0o644)
    program("more/tool", SCRIPT)
    first, both = {"PATH": f"{folder}/bin"}, {"PATH": f"{folder}/bin:{folder}/more"}
    fault = fault_of("tool", first)
    assert fault is not None
    assert fault.text == f"'{folder}/bin/tool' is not executable"
    assert fault_of("tool", both) is None
    assert str(fault_of("tol", both)) == (
        "there is no program 'tol' in PATH; hint: did you mean 'tool'?"
    )


def test_a_file_of_the_working_directory_needs_a_slash():
    program("x.py", SCRIPT)
    fault = fault_of("x.py", os.environ)
    assert fault is not None
    assert fault.text == "there is no program 'x.py' in PATH"
    assert fault.hint == "write './x.py' for the file in the working directory"


@pytest.mark.parametrize("word", ["x.py", "./x.py"])
def test_a_file_beside_the_launch_file_is_told(word: str, folder: Path):
    program("launch/x.py", SCRIPT)
    fault = fault_of(word, os.environ, beside=str(folder / "launch"))
    assert fault is not None
    assert str(fault.hint).startswith("it is beside the launch file: write os.path.join(")
    assert str(fault.hint).endswith("$(dirname)/x.py")


def test_the_working_directory_of_the_process_counts(folder: Path):
    program("sub/x", SCRIPT)
    assert fault_of("./x", os.environ, cwd=str(folder / "sub")) is None
    assert str(fault_of("./x", os.environ, cwd="/no/such")) == (
        "the working directory '/no/such' is no folder"
    )
    fault = fault_of("./y", os.environ, cwd="sub")
    assert fault is not None
    assert fault.text == "there is no './y' in 'sub'"
