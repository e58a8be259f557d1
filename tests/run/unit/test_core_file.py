"""The patterns of the kernel for core files, and what is told of each."""

from __future__ import annotations

import fnmatch
import resource
import signal
import struct
from pathlib import Path

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.spec import Limits, ProcessSpec
from launcher.posix import proc
from launcher.run.logs import core_file
from launcher.run.logs.core_file import CorePattern, note_of
from launcher.run.processes.process import Process

DUMPED = Outcome(returncode=-signal.SIGSEGV, core_dumped=True)
NOT_DUMPED = Outcome(returncode=-signal.SIGSEGV)
SESSION = 4711


@pytest.mark.parametrize(
    ("text", "uses_pid", "path"),
    [
        ("core", False, "/run/here/core"),
        ("core", True, "/run/here/core.7"),
        ("core.%p", True, "/run/here/core.7"),
        ("/var/cores/%e-%p-%t", False, "/var/cores/robot [1]-7-1700000000"),
        ("/var/%h/100%%/core.%E", False, "/var/host/100%/core.!usr!bin!robot"),
        ("cores/[%s]", False, "/run/here/cores/[11]"),
        ("", True, "/run/here/.7"),
        ("%", False, "/run/here/"),
    ],
)
def test_the_name_that_the_kernel_makes_of_a_pattern_fits(text, uses_pid, path):
    assert fnmatch.fnmatchcase(path, CorePattern(text, uses_pid).glob("/run/here"))


def test_names_of_another_folder_do_not_fit():
    assert not fnmatch.fnmatchcase("/run/there/core", CorePattern("core").glob("/run/here"))


@pytest.mark.parametrize(
    ("text", "handler"),
    [
        ("|/usr/lib/systemd/systemd-coredump %P %u", "/usr/lib/systemd/systemd-coredump"),
        ("| /bin/keep", "/bin/keep"),
        ("core.%p", ""),
    ],
)
def test_the_program_that_gets_core_dumps(text, handler):
    assert CorePattern(text).handler == handler


@pytest.fixture
def told(tmp_path: Path, monkeypatch):
    """What is told of a death in a folder, with this pattern of the kernel."""
    kernel = tmp_path / "proc/sys/kernel"
    kernel.mkdir(parents=True)
    monkeypatch.setattr(proc, "ROOT", str(tmp_path / "proc"))

    def tell(pattern: str, outcome: Outcome = DUMPED, limits: Limits | None = None) -> str:
        (kernel / "core_pattern").write_text(f"{pattern}\n")
        (kernel / "core_uses_pid").write_text("0\n")
        spec = ProcessSpec(
            name="arm-1", label="arm", argv=("arm",), env={}, cwd=str(tmp_path), limits=limits
        )
        return note_of(Process(1, spec, number=0, prefix=b""), SESSION, outcome)

    return tell


def written(path: Path, session: int, program: str = "/usr/bin/my arm") -> None:
    """A core file with the notes that the kernel writes, and no memory."""
    info = bytes(24) + struct.pack("4i", session, 1, session, session) + bytes(96)
    name = program.encode() + b"\0/lib/libc.so\0"
    files = struct.pack("QQ", 2, 4096) + bytes(48) + name
    notes = b"".join(
        struct.pack("III", 5, len(content), kind) + b"CORE\0\0\0\0" + content + pad(content)
        for kind, content in ((core_file._PSINFO, info), (core_file._FILES, files))
    )
    head = b"\x7fELF\x02\x01\x01" + bytes(9) + struct.pack("HHIQQQIHHHHHH", 4, 62, 1, 0, 64, 0, 0,
                                                            64, 56, 1, 0, 0, 0)  # fmt: skip
    table = struct.pack("IIQQQQQQ", 4, 0, 64 + 56, 0, 0, len(notes), 0, 4)
    path.write_bytes(head + table + notes)


def pad(content: bytes) -> bytes:
    return bytes(-len(content) % 4)


def test_the_core_file_of_this_process_is_named_with_the_command_that_opens_it(told, tmp_path):
    written(tmp_path / "core.8", 8)
    written(tmp_path / "core.9", SESSION)
    (tmp_path / "core.10").write_text("not a core file")
    (tmp_path / "core.11").write_bytes(b"\x7fELF\x02 cut off")
    (tmp_path / "core.12").mkdir()
    path = tmp_path / "core.9"
    opened = f"to open it: gdb '/usr/bin/my arm' {path}"
    assert told("core.%p") == f"core file: {path}; {opened}"


def test_of_a_python_program_the_command_for_its_python_stack_is_told_too(told, tmp_path):
    written(tmp_path / "core", SESSION, "/usr/bin/python3.11")
    assert told("core").endswith(f"or for the Python stack: py-spy dump --core {tmp_path / 'core'}")


def test_a_shell_that_passes_on_the_signal_of_its_command(told, tmp_path):
    outcome = Outcome(returncode=128 + signal.SIGSEGV)
    assert told("core", outcome) == ""
    assert told("|/bin/handler", outcome) == ""
    written(tmp_path / "core", SESSION)
    assert told("core", outcome).startswith(f"core file: {tmp_path / 'core'};")


def test_no_core_is_expected_of_other_exits(told, tmp_path):
    written(tmp_path / "core", SESSION)
    for code in (-signal.SIGKILL, -signal.SIGTERM, 1, 128, 128 + signal.SIGTERM, 255):
        assert told("core", Outcome(returncode=code)) == ""


def test_a_core_file_that_is_not_found_is_told_with_the_pattern(told, tmp_path):
    written(tmp_path / "core", 8)
    assert "not found: the pattern of the kernel is 'core'" in told("core")
    assert f"started in {tmp_path}" in told("core")


@pytest.mark.parametrize(
    ("pattern", "says"),
    [
        ("|/lib/systemd/systemd-coredump %P", f"coredumpctl debug {SESSION}"),
        ("|/usr/share/apport/apport -p%p", "apport-unpack /var/crash/"),
        ("|/opt/keep %p", "the kernel has passed it to /opt/keep"),
    ],
)
def test_what_a_program_got_is_told_with_how_to_open_it(told, pattern, says):
    assert says in told(pattern)
    assert "on the host of this container" in told(pattern.replace("|/", "|/absent/"))


def test_how_to_get_a_core_file_is_told_where_the_limit_forbids_one(told, monkeypatch):
    monkeypatch.setattr(resource, "getrlimit", lambda which: (0, -1))
    assert told("core", NOT_DUMPED).endswith("--limit arm:core=unlimited")
    own = Limits(rlimits=(("core", 1024, 1024),))
    assert told("core", NOT_DUMPED, own).endswith("'core' could not be written")
    assert "/opt/keep, which failed" in told("|/opt/keep", NOT_DUMPED)


def test_the_next_start_does_not_wait_for_modules_that_only_a_core_file_needs():
    assert {"glob", "resource", "shlex", "struct"}.isdisjoint(vars(core_file))
