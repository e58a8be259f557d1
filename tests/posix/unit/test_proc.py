"""Readers of /proc, for this process and for a made-up one."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from launcher.posix import proc
from launcher.posix.cleanup.run_id import run_id_of
from launcher.ros.discovery.gids import sockets_of

PID = 4711
FIELDS = "T 1 4711 4711 0 -1 0 0 0 0 0 250 50 0 0 20 0 1 0 12345 0"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(proc, "ROOT", str(tmp_path))
    process = tmp_path / str(PID)
    process.mkdir()
    (process / "stat").write_text(f"{PID} (a) R (b c)) {FIELDS}\n")
    (process / "status").write_text("Name:\tx\nNSpid:\t4711\t12\n")
    (process / "cmdline").write_bytes(b"python3\0-c\0\xff\0")
    (process / "comm").write_text("python3\n")
    (process / "environ").write_bytes(
        b"X_LAUNCHER_RUN_ID=1\0LAUNCHER_RUN_ID=7-" + 20_000 * b"y" + b"\0"
    )
    return process


def test_the_fields_of_stat_begin_behind_the_last_parenthesis(folder: Path):
    fields = proc.stat_fields(PID)
    assert (fields[proc.USER_TICKS], fields[proc.SYSTEM_TICKS]) == (b"250", b"50")
    assert proc.start_ticks(PID) == 12345
    assert proc.state(PID) == "T"
    assert proc.is_suspended(PID)
    assert proc.is_alive(PID)


def test_a_zombie_is_neither_running_nor_has_a_start_time(folder: Path):
    (folder / "stat").write_text(f"{PID} (x) Z{FIELDS[1:]}\n")
    assert not proc.is_alive(PID)
    assert proc.start_ticks(PID) is None


def test_a_value_is_found_by_its_whole_name(folder: Path):
    assert proc.status_field(PID, "NSpid") == "4711\t12"
    assert proc.status_field(PID, "NS") == ""
    assert run_id_of(PID) == "7-" + 20_000 * "y"


def test_a_command_line_survives_bytes_that_are_not_utf_8(folder: Path):
    assert proc.command_line(PID) == ["python3", "-c", os.fsdecode(b"\xff")]
    assert proc.command_name(PID) == "python3"
    (folder / "cmdline").write_bytes(b"")
    assert proc.command_line(PID) == []


def test_the_paths_of_mapped_files_may_have_blanks(folder: Path):
    (folder / "maps").write_text(
        "7f00-7f01 r--p 00000000 fd:00 17     /opt/my libraries/a.so\n"
        "7f01-7f02 r-xp 00001000 fd:00 17     /opt/my libraries/a.so\n"
        "7f02-7f03 rw-p 00000000 00:00 0 \n"
        "7f03-7f04 rw-s 00000000 00:1a 5      /dev/shm/b (deleted)\n"
    )
    assert proc.mapped(PID) == {"/opt/my libraries/a.so", "/dev/shm/b (deleted)"}
    assert proc.mapped(1) == set()


def test_the_sockets_of_both_tables_are_read(folder: Path):
    net = folder.parent / "net"
    net.mkdir()
    line = "7: 00000000:1CF2 00000000:0000 07 0:0 00:0 0 1000 0 {} 2 0 0\n"
    (net / "udp").write_text("header\n" + line.format(91))
    (net / "udp6").write_text("header\n" + line.format(92))
    assert set(proc.udp_sockets()) == {(0x1CF2, "91"), (0x1CF2, "92")}


def test_a_file_that_is_closed_while_they_are_read_hides_no_other(folder: Path):
    (folder / "fd").mkdir()
    for number in range(3, 20):
        path = folder / "fd" / str(number)
        if number % 2:
            path.symlink_to(f"socket:[{number}]")
        else:
            path.touch()  # readlink fails
    assert set(proc.descriptors(PID)) == {(n, f"socket:[{n}]") for n in range(3, 20, 2)}
    assert sockets_of(PID) == {str(n) for n in range(3, 20, 2)}


def test_an_ended_process_has_no_data(folder: Path):
    assert proc.pids() == [PID]
    assert proc.state(1) == ""
    assert not proc.is_alive(1)
    assert not proc.is_suspended(1)
    assert proc.start_ticks(1) is None
    assert proc.command_line(1) == []
    assert list(proc.descriptors(1)) == []
    assert run_id_of(1) is None
    assert proc.pid_namespace(1) is None


def test_a_machine_without_proc_has_no_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(proc, "ROOT", str(tmp_path / "absent"))
    assert proc.pids() == []
    assert list(proc.udp_sockets()) == []


def test_this_process_is_there():
    own = os.getpid()
    assert own in proc.pids()
    assert proc.state(own) in ("R", "S")
    assert proc.command_line(own)
    assert proc.pid_namespace(own)
    started = proc.start_ticks(own)
    assert started
    assert started / os.sysconf("SC_CLK_TCK") <= time.clock_gettime(time.CLOCK_BOOTTIME)
