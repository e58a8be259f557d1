"""Load tests: many processes, lines and restarts, full disks, few descriptors."""

from __future__ import annotations

import re
import shlex
import subprocess
import time
from pathlib import Path

import psutil
import pytest

from tests.support.benches import Bench
from tests.support.waiting import wait_until

pytestmark = pytest.mark.thorough

TIMEOUT_S = 300.0  # tens of megabytes, perhaps on a busy machine
MB = 1024 * 1024


def _cat(path: Path, times: int) -> str:
    """The actions of a launch file that prints this file so many times, at once."""
    one = f'ExecuteProcess(cmd=["cat", "{path}"], output="screen")'
    return f"*[{one} for _ in range({times})]"


def _numbered(folder: Path, count: int) -> tuple[Path, list[str]]:
    """A file of lines that are all different, and the lines."""
    lines = [f"line {number:06} of {count}, whole to its very end." for number in range(count)]
    path = folder / "lines"
    path.write_text("".join(f"{line}\n" for line in lines))
    return path, lines


def _printed(output: bytes) -> dict[str, list[str]]:
    """What each process printed, by its name; our own lines are left out."""
    found: dict[str, list[str]] = {}
    for line in output.decode().splitlines():
        prefix = re.match(r"\[([\w-]+-\d+)\] ", line)
        if prefix is not None:
            found.setdefault(prefix[1], []).append(line[prefix.end() :])
    return found


def _bash(bench: Bench, script: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        ["bash", "-c", script],
        env=bench.env,
        capture_output=True,
        timeout=TIMEOUT_S,
        check=False,
    )


def _read_until(process: subprocess.Popen[bytes], text: bytes) -> bytes:
    """Read lines up to the one that contains the text; that line."""
    assert process.stdout is not None
    for line in process.stdout:
        if text in line:
            return line
    raise AssertionError(f"the output ended before {text!r}")


def _stop(process: subprocess.Popen[bytes]) -> int:
    process.terminate()
    process.communicate(timeout=TIMEOUT_S)
    return process.returncode


def test_200_children_with_5000_lines_each_arrive_complete_and_whole(bench: Bench):
    path, lines = _numbered(bench.folder, 5000)
    command = shlex.join(bench.command(_cat(path, 200)))
    output = bench.folder / "output"
    done = _bash(bench, f"{command} | cat > {output}; exit ${{PIPESTATUS[0]}}")
    assert done.returncode == 0, done.stderr
    printed = _printed(output.read_bytes())
    assert len(printed) == 200
    assert [name for name, its_lines in printed.items() if its_lines != lines] == []


# Counts its starts, and rests at the 10th and at the 510th until the test lets it go on.
RESTARTED = """
read n < count; n=$((n + 1)); echo $n > count
case $n in 10 | 510) echo resting $n; while [ ! -e go-$n ]; do sleep 0.02; done;; esac
exit 1
"""


def test_500_restarts_leave_no_descriptor_behind(bench: Bench):
    (bench.folder / "node.sh").write_text(RESTARTED)
    (bench.folder / "count").write_text("0\n")
    process = bench.start(f'sh(". ./node.sh", cwd="{bench.folder}", respawn=True)', "--no-control")
    launcher = psutil.Process(process.pid)  # its socket would be opened at a moment of its own
    _read_until(process, b"resting 10")
    log = bench.folder / "log" / "latest" / "sh-1.log"
    wait_until(log.exists, "the log file is opened, which is after the line was shown")
    before = launcher.num_fds()
    (bench.folder / "go-10").touch()
    _read_until(process, b"resting 510")
    wait_until(lambda: launcher.num_fds() <= before, "no more descriptors than before")
    assert _stop(process) == 0


def test_an_output_that_nobody_reads_for_10_s_costs_no_memory_and_no_line(bench: Bench):
    path, lines = _numbered(bench.folder, 100_000)
    process = bench.start(_cat(path, 8))
    launcher = psutil.Process(process.pid)
    sizes = [0]
    until = time.monotonic() + 10.0

    def is_over() -> bool:
        sizes.append(launcher.memory_info().rss)
        return time.monotonic() >= until

    wait_until(is_over, "10 s go by")
    output, _ = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0
    assert max(sizes) < 32 * MB < 8 * path.stat().st_size
    printed = _printed(output)
    assert [len(its_lines) for its_lines in printed.values()] == [len(lines)] * 8
    assert all(its_lines == lines for its_lines in printed.values())


def test_two_runs_of_one_launch_file_do_not_touch_each_other(bench: Bench):
    actions = 'sh("echo I am $$; exec sleep 1000")'
    command = bench.command(actions)  # once: the first run may read while it is written
    pipe = subprocess.PIPE
    runs = [subprocess.Popen(command, env=bench.env, stdout=pipe, stderr=pipe) for _ in range(2)]
    said = [_read_until(run, b"I am ") for run in runs]
    children = [psutil.Process(int(line.split()[-1])) for line in said]
    assert _stop(runs[0]) == 0
    wait_until(lambda: not children[0].is_running(), "the first run's child is gone")
    assert children[1].is_running()
    assert runs[1].poll() is None
    assert _stop(runs[1]) == 0
    logs = [path.read_bytes() for path in bench.folder.glob("log/*/sh-1.log")]
    # `latest` is a second way to one of the two.
    assert {b"".join(said).splitlines(keepends=True)[n] for n in (0, 1)} == set(logs)


def test_too_few_descriptors_stop_some_processes_and_not_the_run(bench: Bench):
    command = shlex.join(bench.command('*[sh("echo hello; sleep 0.5") for _ in range(30)]'))
    done = _bash(bench, f"ulimit -n 40; exec {command}")
    out = done.stdout.decode()
    refused = re.findall(r"\[sh-\d+\]: process could not be started: Too many open files", out)
    assert refused
    assert done.stdout.count(b"] hello\n") == 30 - len(refused) > 0
    assert done.returncode == 1
    assert bench.survivors() == []


def test_a_disk_that_fills_up_is_reported_once_and_loses_no_line_on_the_screen(bench: Bench):
    path, lines = _numbered(bench.folder, 5000)
    command = shlex.join(bench.command(_cat(path, 3)))
    done = _bash(bench, f"ulimit -f 64; exec {command}")  # KiB: no file grows beyond it
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(b"no log files from here on: File too large") == 1
    assert list(_printed(done.stdout).values()) == [lines] * 3


def test_a_screen_on_a_full_disk_does_not_stop_the_run(bench: Bench):
    path, lines = _numbered(bench.folder, 5000)
    command = shlex.join(bench.command(_cat(path, 1)))
    done = _bash(bench, f"exec {command} > /dev/full")
    assert done.returncode == 1 and done.stderr.count(b"No space left on device") == 1
    run = bench.folder / "log" / "latest"
    assert _printed((run / "cat-1.log").read_bytes()) == {"cat-1": lines}
    assert "bytes of output: the disk was full" in (run / "launch.log").read_text()


def test_head_gets_its_lines_and_ends_a_flood_quietly(bench: Bench):
    command = shlex.join(bench.command('*[sh("exec yes") for _ in range(4)]'))
    done = _bash(bench, f"{command} | head -n 5000; exit ${{PIPESTATUS[0]}}")
    assert len(done.stdout.splitlines()) == 5000
    assert (done.returncode, done.stderr) == (0, b"")
    assert bench.survivors() == []
