"""Find flaky tests: run `make TARGET` repeatedly, alternately on an idle and a busy machine.

    python -m tools.hunt test --runs 20

Prints a row per run and finally each test that failed. The output of each run is kept in the
folder `--output`. The exit code is 1 if a run failed.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

BUSY = "while True: pass"
LOOPS_PER_CORE = 3
FAILURE = re.compile(r"^(?:FAILED|ERROR) (tests/.+?)(?: - .*)?$", re.MULTILINE)
PASSED = re.compile(r"(\d+) passed")


@dataclass(frozen=True, kw_only=True)
class Run:
    """One `make TARGET`."""

    number: int
    loops: int
    code: int
    took_s: float
    passed: int
    failures: list[str]

    def __str__(self) -> str:
        load = f"{self.loops} busy loops" if self.loops else "idle"
        outcome = "green" if self.code == 0 else f"RED ({len(self.failures)} failed)"
        minutes, seconds = divmod(round(self.took_s), 60)
        return f"{self.number:4}  {load:13} {minutes:3}:{seconds:02}  {self.passed:5}  {outcome}"


@contextlib.contextmanager
def busy_loops(count: int) -> Iterator[None]:
    """Run `count` processes that keep a core busy."""
    loops = [subprocess.Popen([sys.executable, "-S", "-c", BUSY]) for _ in range(count)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def run(number: int, target: str, loops: int, log: Path) -> Run:
    """Run the target once, with its output in `log`."""
    start_s = time.monotonic()
    with busy_loops(loops), log.open("w", encoding="utf-8") as file:
        code = subprocess.run(["make", target], stdout=file, stderr=subprocess.STDOUT).returncode
    text = log.read_text(encoding="utf-8", errors="replace")
    return Run(
        number=number,
        loops=loops,
        code=code,
        took_s=time.monotonic() - start_s,
        passed=sum(map(int, PASSED.findall(text))),
        failures=FAILURE.findall(text),
    )


def main() -> int:
    parser = argparse.ArgumentParser(description="Find flaky tests.")
    parser.add_argument("target", nargs="?", default="test", help="make target: test, check, unit")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--output", type=Path, default=Path("build/hunt"))
    parser.add_argument(
        "--loops",
        type=int,
        default=LOOPS_PER_CORE * len(os.sched_getaffinity(0)),
        help="busy loops during every second run (default: %(default)s); 0: none",
    )
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    failed: dict[str, list[int]] = defaultdict(list)
    is_green = True
    print(" run  machine        time  passed  outcome", flush=True)
    for number in range(1, options.runs + 1):
        log = options.output / f"{options.target}-{number:02}.txt"
        one = run(number, options.target, options.loops * (1 - number % 2), log)
        print(one, flush=True)
        is_green &= one.code == 0
        for test in one.failures:
            failed[test].append(number)
    for test, numbers in sorted(failed.items()):
        print(f"{test} failed in {', '.join(map(str, numbers))}: see {options.output}")
    return 0 if is_green else 1


if __name__ == "__main__":
    sys.exit(main())
