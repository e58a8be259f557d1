"""Many mutated bags through all verbs of `bag`: `python -m tests.fuzz.bags --count 3000`."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from tests.fuzz.bags.seeds import KINDS, write_all
from tests.fuzz.bags.worker import MEMORY_BYTES, VERBS
from tests.support.repository import REPOSITORY

_HANG_S = 60.0  # for all verbs of one bag, which take a part of a second


@dataclass(slots=True)
class Result:
    """How often each verb ended in which way, by kind; `problems` are the faults found."""

    codes: Counter[tuple[str, str, int]] = field(default_factory=Counter)
    problems: list[str] = field(default_factory=list)
    most_kib: int = 0
    cases: int = 0

    def add(self, other: Result) -> None:
        self.codes += other.codes
        self.problems += other.problems
        self.most_kib = max(self.most_kib, other.most_kib)
        self.cases += other.cases

    def lines(self) -> Iterator[str]:
        """A table: of each kind and verb, how many succeeded and how many ended in an error."""
        kinds = [kind for kind in KINDS if any(one == kind for one, _, _ in self.codes)]
        yield f"| verb (0 / 1) | {' | '.join(kinds)} |"
        yield f"|---|{'---|' * len(kinds)}"
        for verb in VERBS:
            cells = (f"{self.codes[kind, verb, 0]} / {self.codes[kind, verb, 1]}" for kind in kinds)
            yield f"| {verb} | {' | '.join(cells)} |"
        yield ""
        yield f"{self.cases} bags, {self.codes.total()} runs of verbs"
        yield f"memory: at most {self.most_kib // 1024} MB"
        yield f"faults: {len(self.problems)}"


class _Worker:
    """A process that runs verbs; started again after a crash or a hang."""

    def __init__(self, seeds: Path, folder: Path) -> None:
        self._words = [sys.executable, "-m", "tests.fuzz.bags.worker", str(seeds), str(folder)]
        self._process: subprocess.Popen[bytes] | None = None

    def run(self, kind: str, number: int) -> dict[str, dict[str, object]] | str:
        """The outcomes by verb, or what became of the process."""
        if self._process is None:
            self._process = subprocess.Popen(
                self._words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=REPOSITORY
            )
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(f"{kind} {number}\n".encode())
        process.stdin.flush()
        if not select.select([process.stdout], [], [], _HANG_S)[0]:
            process.kill()
        line = process.stdout.readline()
        if line.endswith(b"\n"):
            found: dict[str, dict[str, object]] = json.loads(line)
            return found
        self._process = None
        return f"the process ended with {process.wait()} (-9: it hung)"

    def close(self) -> None:
        if self._process is not None:
            assert self._process.stdin is not None
            self._process.stdin.close()
            self._process.wait()


def run(kinds: Iterable[str], numbers: range, workers: int = 1) -> Result:
    """Mutate the bags of these kinds, each by all numbers."""
    whole = Result()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(workers) as pool:
        seeds = Path(folder, "seeds")
        seeds.mkdir()
        write_all(seeds)
        cases = [(kind, number) for number in numbers for kind in kinds]
        parts = [
            pool.submit(_part, seeds, Path(folder, str(part)), cases[part::workers])
            for part in range(workers)
        ]
        for one in parts:
            whole.add(one.result())
    return whole


def _part(seeds: Path, folder: Path, cases: list[tuple[str, int]]) -> Result:
    result = Result()
    worker = _Worker(seeds, folder)
    try:
        for kind, number in cases:
            result.cases += 1
            found = worker.run(kind, number)
            if isinstance(found, str):
                result.problems.append(f"{kind} {number}: {found}")
                continue
            for verb, outcome in found.items():
                _add(result, kind, number, verb, outcome)
    finally:
        worker.close()
    return result


def _add(result: Result, kind: str, number: int, verb: str, outcome: dict[str, object]) -> None:
    result.codes[kind, verb, int(str(outcome["code"]))] += 1
    kib = int(str(outcome["kib"]))
    result.most_kib = max(result.most_kib, kib)
    problem = outcome["problem"]
    if not problem and kib * 1024 > MEMORY_BYTES:
        problem = f"it took {kib // 1024} MB"
    if problem:
        result.problems.append(f"{kind} {number}, bag {verb}: {problem}")


def cores() -> int:
    return len(os.sched_getaffinity(0))
