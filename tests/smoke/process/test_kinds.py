"""Kinds of expectations that need no ROS, met and not met by real processes."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.smoke.process.bench import DONE, PATIENT, SHORT, Bench

_BROKEN = """
import time, traceback
print("[ERROR] [broken]: no dock", flush=True)
try:
    {}["dock"]
except KeyError:
    traceback.print_exc()
time.sleep(1000)
"""
ERRORS = f'py("broken", {_BROKEN!r}),'
BUSY = 'py("busy", "while True: pass"),'
LARGE = 'py("large", "x = bytearray(150 << 20); import time; time.sleep(1000)"),'
ORDERLY = 'sh("orderly", "echo first; echo second; exec sleep 1000"),'
RESTLESS = 'sh("restless", "echo again; sleep 0.2; exit 1", respawn=True),'


@pytest.mark.thorough
def test_lines_processes_and_the_run(bench: Bench):
    bench.write(PATIENT, SHORT, DONE, ORDERLY)
    bench.expect(
        """
        expect:
          - {name: good line, log: here, process: patient, within: 60 s}
          - {name: bad line, log: there, process: patient}
          - {name: good count, log: here, count: 1}
          - {name: bad count, log: here, count: '>= 2'}
          - {name: good order, order: [^first, ^second], within: 1 min}
          - {name: bad order, order: [done, never]}
          - {name: good exit, process: short, exits: 3, within: 60 s}
          - {name: bad exit, process: done, exits: 3, within: 60 s}
          - {name: good life, process: patient}
          - {name: bad life, process: done}
          - {name: good death, process: done, alive: false}
          - {name: bad death, process: patient, alive: false}
          - {name: good start, start_up: 60 s}
          - {name: bad start, start_up: 0.001 s}
          - {name: good shutdown, clean_shutdown: 60 s}
          - {name: bad shutdown, clean_shutdown: 0.0001 s}
          - {name: good errors, no_errors: patient}
          - {name: bad errors, no_errors: '*'}
          - {name: good memory, shared_memory: clean}
        """
    )
    done = bench.smoke()
    outcomes = bench.outcomes()
    assert done.returncode == 3
    for name, outcome in outcomes.items():
        assert outcome == ("violated" if name.startswith("bad") else "met"), name


@pytest.mark.thorough
def test_errors_and_tracebacks(bench: Bench):
    bench.write(PATIENT, ERRORS)
    bench.expect("{expect: [{name: all is printed, log: KeyError, within: 60 s}]}")
    bench.smoke("--expect-no-errors", "--expect-no-errors=patient", "--expect-no-tracebacks")
    assert bench.judged("no errors *")["seen"].endswith("[ERROR] [broken]: no dock")
    assert bench.outcomes()["no errors patient"] == "met"
    assert bench.judged("no tracebacks *")["seen"].endswith("KeyError: 'dock'")


@pytest.mark.thorough
def test_use_of_resources(bench: Bench):
    bench.write(PATIENT, BUSY, LARGE)
    bench.smoke(
        "--for=10",  # the first look comes late on a busy machine
        "--expect-cpu=busy=2%",
        "--expect-cpu=patient=20%",
        "--expect-memory=large=100MB",
        "--expect-memory=patient=100MB",
    )
    assert bench.outcomes() == {
        "cpu busy": "violated",
        "cpu patient": "met",
        "memory large": "violated",
        "memory patient": "met",
        "no unexpected exits": "met",
    }


@pytest.mark.thorough
def test_restarts(bench: Bench):
    bench.write(RESTLESS)
    bench.expect(
        """
        expect:
          - {process: restless, restarts: '>= 2', within: 60 s}
          - {process: restless, restarts: 0}
          - {process: restless, exits: 1}
        """
    )
    bench.smoke()
    assert list(bench.outcomes().values()) == ["met", "violated", "met", "met"]


@pytest.mark.thorough
def test_what_is_left_in_shared_memory(bench: Bench, tmp_path: Path):
    name = f"smoke-test-{tmp_path.name}-{tmp_path.parent.name}"
    script = (
        "import mmap, os, time\\n"
        f"fd = os.open('/dev/shm/{name}', os.O_RDWR | os.O_CREAT)\\n"
        "os.truncate(fd, 4096)\\n"
        "kept = mmap.mmap(fd, 4096)\\n"
        "print('mapped')\\n"
        "time.sleep(1000)"
    )
    bench.write(f'py("untidy", "{script}"),')
    bench.expect("{expect: [{log: mapped, within: 60 s}]}")
    try:
        done = bench.smoke("--expect-shared-memory")
    finally:
        Path("/dev/shm", name).unlink(missing_ok=True)
    assert done.returncode == 3
    assert bench.judged("shared memory clean")["seen"] == f"1: {name}"
