"""Runs the shipped smoke files on the fleet, and on each mutant of it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.contestant import REPOSITORY
from benchmarks.harness import Row, scratch
from benchmarks.mutants.mutations import MUTANTS, SMOKE_FILES, SYSTEM, WAREHOUSE, Mutant

PACKAGE = "group_gp1"
COPIED = (PACKAGE, "launch", "resource", "package.xml", "setup.cfg", "setup.py")
TOGETHER = 2  # runs at a time: each has ten processes that mostly wait
RUN_S = 600.0
_MOST_NAMED = 3
_PRINT_PROGRAM = f"""
import os
from launcher.packages import finder
print(finder.executable_paths({PACKAGE!r}, os.environ)["dispatcher"].read_text())
"""


def mutants(runs: int, only: Sequence[str] = ()) -> list[Row]:
    """The number of expectations that see each mutant, which is tried with one file after another.

    `runs`: of the healthy fleet, with each file; none if `only` names mutants.
    """
    healthy = [] if only else [name for name in SMOKE_FILES for _ in range(runs)]
    chosen = [mutant for mutant in MUTANTS if not only or mutant.name in only]
    with ThreadPoolExecutor(TOGETHER) as pool:
        return [*pool.map(_healthy, healthy), *pool.map(_mutated, chosen)]


def _healthy(smoke_file: str) -> Row:
    seen = _violated(None, smoke_file)
    return _noted(Row(f"fleet, {smoke_file}", len(seen), "violated", 0, _named(seen)))


def _noted(row: Row) -> Row:
    print(row.what, row.detail, sep=": ", file=sys.stderr, flush=True)
    return row


def _mutated(mutant: Mutant) -> Row:
    files = [mutant.smoke_file, *(name for name in SMOKE_FILES if name != mutant.smoke_file)]
    seen: list[str] = []
    for smoke_file in files:
        if seen := _violated(mutant, smoke_file):
            break
    detail = f"{smoke_file}: {_named(seen)}" if seen else f"not seen by {', '.join(files)}"
    row = Row(f"mutant {mutant.name}", len(seen), "violated", 1, detail, at_least=True)
    return _noted(row)


def _violated(mutant: Mutant | None, smoke_file: str) -> list[str]:
    """The names of the expectations that are not met."""
    with scratch() as folder:
        fleet = folder / "fleet"
        copy_fleet(fleet)
        if mutant is not None:
            text = mutant.mutated(fleet / PACKAGE)
            (fleet / PACKAGE / mutant.file).write_text(text, encoding="utf-8")
        environment = environment_of(fleet, folder / "log")
        return _smoke(smoke_file, fleet, folder / "evidence", environment)


def _smoke(smoke_file: str, fleet: Path, evidence: Path, environment: dict[str, str]) -> list[str]:
    launch_file = WAREHOUSE if smoke_file == WAREHOUSE else SYSTEM
    words = (
        f"launch/{launch_file}.launch.py",
        f"--expect=launch/{smoke_file}.expect.yaml",
        f"--artifacts={evidence}",
    )
    done = subprocess.run(
        [sys.executable, "-m", "launcher", "smoke", *words],
        cwd=fleet,
        env=environment,
        capture_output=True,
        text=True,
        timeout=RUN_S,
        check=False,
    )
    report = evidence / "report.json"
    if not report.exists():
        raise RuntimeError(f"{smoke_file}: exit code {done.returncode}\n{done.stderr}")
    expectations = json.loads(report.read_text(encoding="utf-8"))["expectations"]
    seen = [one["name"] for one in expectations if one["outcome"] == "violated"]
    return seen if seen or not done.returncode else [f"exit code {done.returncode}"]


def copy_fleet(folder: Path) -> None:
    """Copy the package to an empty folder, where the launcher finds it in place of the checkout."""
    folder.mkdir()
    for name in COPIED:
        source = REPOSITORY / name
        copy = shutil.copytree if source.is_dir() else shutil.copy
        copy(source, folder / name)
    # Without it the launcher would run the programs of the installed distribution.
    subprocess.run([sys.executable, "setup.py", "-q", "egg_info"], cwd=folder, check=True)


def environment_of(folder: Path, logs: Path) -> dict[str, str]:
    """That of a run of the fleet in `folder`; RuntimeError if its nodes would be of another one."""
    path = os.pathsep.join((str(folder), str(REPOSITORY)))
    environment = {**os.environ, "PYTHONPATH": path, "ROS_LOG_DIR": str(logs)}
    command = [sys.executable, "-c", _PRINT_PROGRAM]
    program = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=True
    ).stdout
    if f"sys.path[0] = {str(folder)!r}" not in program:
        raise RuntimeError(f"the mutants are not used, but:\n{program}")
    return environment


def _named(names: Iterable[str]) -> str:
    known = list(names)
    more = f" and {len(known) - _MOST_NAMED} more" if len(known) > _MOST_NAMED else ""
    return ", ".join(known[:_MOST_NAMED]) + more
