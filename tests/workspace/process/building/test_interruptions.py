"""A build that is stopped, killed, or meets another one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from tests.support.hostile_parent import with_signals
from tests.support.waiting import rest_of, wait_until
from tests.workspace.process.building.small_packages import (
    COMMAND,
    TIMEOUT_S,
    built,
    cmake_package,
    files_package,
    python_package,
    write,
)

SLEEP = "execute_process(COMMAND sleep 1000)"
NOBODY = 65534
KILLER = f"""
import os, subprocess
from launcher.workspace.building.colcon import descendants
print(subprocess.Popen(["sleep", "1000"]).pid, flush=True)
os.setresuid({NOBODY}, {NOBODY}, {NOBODY})
descendants.kill()
"""


class RunningBuild:
    """A build whose package `slow` waits in CMake; `terminal` is its standard files."""

    def __init__(self, root: Path, *command: str, terminal: int | None = None) -> None:
        self.root = root
        self.process = subprocess.Popen(
            command or COMMAND,
            cwd=root,
            stdin=subprocess.DEVNULL if terminal is None else terminal,
            stdout=subprocess.PIPE if terminal is None else terminal,
            stderr=subprocess.PIPE if terminal is None else terminal,
            text=True,
        )

    def waits(self) -> bool:
        try:
            return any(process.name() == "sleep" for process in self.below())
        except psutil.NoSuchProcess:  # it ended while it was looked at
            return False

    def below(self) -> list[psutil.Process]:
        return psutil.Process(self.process.pid).children(recursive=True)

    def first_line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline()

    def end(self) -> tuple[int, str, str]:
        out, err = rest_of(self.process, TIMEOUT_S)
        return self.process.returncode, out, err


def mend(root: Path) -> None:
    cmake_package(root / "src", "slow", "install(DIRECTORY launch DESTINATION share/slow)")


@pytest.fixture
def running(tmp_path: Path) -> Iterator[RunningBuild]:
    cmake_package(tmp_path / "src", "slow", SLEEP)
    build = RunningBuild(tmp_path)
    try:
        wait_until(build.waits, "CMake waits")
        yield build
    finally:
        if build.process.poll() is None:
            build.process.kill()
            build.end()


def is_alive(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 143)]
)
def test_a_signal_ends_all_and_the_next_build_works(running: RunningBuild, number: int, code: int):
    processes = running.below()

    running.process.send_signal(number)

    assert running.end()[0] == code
    assert not any(map(is_alive, processes))
    mend(running.root)
    assert built(running.root).summary == "1 package: 1 built, 0 unchanged"


@pytest.mark.thorough
def test_signals_that_were_ignored_and_blocked_end_a_build(tmp_path: Path):
    cmake_package(tmp_path / "src", "slow", SLEEP)
    build = RunningBuild(tmp_path, *with_signals(COMMAND))
    wait_until(build.waits, "CMake waits")
    processes = build.below()

    build.process.send_signal(signal.SIGHUP)  # is respected
    build.process.send_signal(signal.SIGINT)

    assert build.end()[0] == 130
    assert not any(map(is_alive, processes))


@pytest.mark.thorough
def test_a_build_succeeds_where_sigchld_is_ignored(tmp_path: Path):
    python_package(tmp_path / "src", "plain")
    command = with_signals(COMMAND)
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=TIMEOUT_S)
    assert done.returncode == 0, done.stderr
    assert "1 package: 1 built, 0 unchanged" in done.stdout


@pytest.mark.thorough
def test_a_terminal_that_is_closed_ends_the_build(tmp_path: Path):
    """The exit code is that of SIGHUP, although nothing can be written any more."""
    cmake_package(tmp_path / "src", "slow", SLEEP)
    ours, theirs = os.openpty()
    build = RunningBuild(tmp_path, "setsid", "--ctty", *COMMAND, terminal=theirs)
    os.close(theirs)
    try:
        wait_until(build.waits, "CMake waits")
        processes = build.below()
    finally:
        os.close(ours)

    assert build.process.wait(TIMEOUT_S) == 143
    assert not any(map(is_alive, processes))


def test_nothing_survives_a_killed_launcher(running: RunningBuild):
    processes = running.below()

    running.process.kill()

    running.end()
    wait_until(lambda: not any(map(is_alive, processes)), "the end of all processes")
    mend(running.root)
    assert built(running.root).summary == "1 package: 1 built, 0 unchanged"


@pytest.mark.thorough
def test_nothing_survives_a_killed_colcon(running: RunningBuild):
    processes = running.below()
    colcon = psutil.Process(running.process.pid).children()[0]

    colcon.kill()

    code, _, err = running.end()
    assert code == 1
    assert "colcon was killed by SIGKILL" in err
    assert not any(map(is_alive, processes))


@pytest.mark.thorough
def test_a_second_build_waits_for_the_first(running: RunningBuild):
    second = RunningBuild(running.root)
    assert f"process {running.process.pid}, since" in second.first_line()

    mend(running.root)
    running.process.send_signal(signal.SIGINT)

    code, out, _ = second.end()
    assert code == 0
    assert out.splitlines()[-1] == "1 package: 1 built, 0 unchanged"


@pytest.mark.thorough
def test_ctrl_c_ends_the_waiting_for_another_build(running: RunningBuild):
    second = RunningBuild(running.root)
    second.first_line()

    second.process.send_signal(signal.SIGINT)

    assert second.end()[0] == 130
    assert running.process.poll() is None


def build_with_mount(root: Path, tmpfs: str, *words: str) -> subprocess.CompletedProcess[str]:
    return run_with_mount(root, tmpfs, *COMMAND, *words)


def run_with_mount(root: Path, tmpfs: str, *command: str) -> subprocess.CompletedProcess[str]:
    """A command with a file system in memory, which other processes do not see."""
    script = f'mount -t tmpfs {tmpfs} && exec "$0" "$@"'
    done = subprocess.run(
        ["unshare", "--mount", "sh", "-c", script, *command],
        cwd=root,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
    )
    if "unshare failed" in done.stderr or "permission denied" in done.stderr:
        pytest.skip(done.stderr)
    return done


@pytest.mark.thorough
@pytest.mark.skipif(os.geteuid() != 0, reason="only root mounts file systems")
@pytest.mark.parametrize(
    ("folder", "size"), [("build", "64k"), ("build", "8k"), ("build", "4k"), ("install", "64k")]
)
def test_a_full_disk_is_an_error_and_the_next_build_works(tmp_path: Path, folder: str, size: str):
    files_package(tmp_path / "src", "files", languages="C CXX")
    write(tmp_path / "src/files/launch/large.bin", "x" * 200_000)
    full = tmp_path / folder
    full.mkdir()

    words = ("--copy", "--compiler", "zig")
    done = build_with_mount(tmp_path, f'-o size={size} none "{full}"', *words)

    assert done.returncode == 1
    assert done.stderr.startswith(f"error: No space left on device: {folder}\nhint: make space")
    assert "Traceback" not in done.stderr
    assert built(tmp_path).summary == "1 package: 1 built, 0 unchanged"


@pytest.mark.thorough
@pytest.mark.skipif(os.geteuid() != 0, reason="only root mounts file systems")
def test_files_that_a_full_disk_has_cut_off_are_not_kept(tmp_path: Path):
    files_package(tmp_path / "src", "files")
    write(tmp_path / "src/files/launch/large.bin", "x" * 200_000)
    (tmp_path / "install").mkdir()

    tmpfs = f'-o size=64k none "{tmp_path}/install"'
    script = '"$@" > output; ls build'
    done = run_with_mount(tmp_path, tmpfs, "sh", "-c", script, "sh", *COMMAND, "--copy")

    assert done.stderr.startswith("error: No space left on device: install\n")
    assert "files" not in done.stdout.split()


@pytest.mark.thorough
@pytest.mark.skipif(os.geteuid() != 0, reason="only root mounts file systems")
def test_a_read_only_folder_is_an_error(tmp_path: Path):
    files_package(tmp_path / "src", "files")
    built(tmp_path)

    done = build_with_mount(tmp_path, f'-o ro none "{tmp_path}/install"')

    assert done.returncode == 1
    assert f"cannot write to {tmp_path}/install" in done.stderr


@pytest.mark.thorough
@pytest.mark.skipif(os.geteuid() != 0, reason="only root mounts file systems")
@pytest.mark.parametrize(
    ("option", "problem", "hint"),
    [
        ("ro", "Read-only file system", "is it read-only, or of another user?"),
        ("nr_inodes=1", "No space left on device", "make space and repeat the command"),
    ],
)
def test_a_lock_that_cannot_be_written_is_named(
    tmp_path: Path, option: str, problem: str, hint: str
):
    python_package(tmp_path / "src", "p")
    folder = tmp_path / "build"
    folder.mkdir()

    command = (*COMMAND[:-1], "wheel", "--all", "-o", str(tmp_path / "elsewhere"))
    done = run_with_mount(tmp_path, f'-o {option} none "{folder}"', *command)

    assert done.returncode == 1
    assert done.stderr.startswith(
        f"error: cannot write to {folder}/.launcher.lock: {problem}\nhint: {hint}"
    )


@pytest.mark.skipif(os.getuid() != 0, reason="only root can start a process that it cannot kill")
def test_a_process_that_cannot_be_killed_does_not_prevent_the_end():
    killer = subprocess.Popen([sys.executable, "-c", KILLER], stdout=subprocess.PIPE, text=True)
    assert killer.stdout is not None
    pid = int(killer.stdout.readline())
    try:
        assert killer.wait(timeout=TIMEOUT_S) == 0
    finally:
        killer.kill()
        os.kill(pid, signal.SIGKILL)
