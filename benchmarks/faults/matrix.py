"""The cells of the fault matrix, their runs, and the tables of what was left."""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, fields

from benchmarks.contestant import REPOSITORY
from benchmarks.faults.cell import (
    CONSOLE,
    LAUNCHER,
    NODE,
    PAGE,
    PHASES,
    PREPARING,
    RECORDER,
    WATCHDOG,
    WATCHER,
    Outcome,
    Spec,
)
from benchmarks.faults.hostile import KINDS
from benchmarks.harness import NotHereError, Row

VICTIMS = (
    (LAUNCHER,),
    (WATCHDOG,),
    (PREPARING,),
    (WATCHER,),
    (PAGE,),
    (RECORDER,),
    (CONSOLE,),
    (NODE,),
    (LAUNCHER, WATCHDOG),
    (LAUNCHER, PREPARING),
    (LAUNCHER, CONSOLE),
    (LAUNCHER, RECORDER),
    (LAUNCHER, NODE),
    (WATCHDOG, NODE),
    (PREPARING, NODE),
)
GROUPS = ("v2", "v1", "none")
ISOLATED = ("unshare", "--mount", "--pid", "--net", "--ipc", "--fork", "--mount-proc")
# An init that reaps what it adopts.
INIT = ("sh", "-c", '"$@"; exit $?', "sh")
CELL_S = 400.0
RESULTS = REPOSITORY / "build" / "faults.json"
COLUMNS = [one.name for one in fields(Outcome) if one.name != "seconds"]


def faults(runs: int) -> list[Row]:
    """`runs` rounds: in each, every victim in every phase with every group, and another child."""
    _check()
    rounds = min(runs, len(KINDS))
    found = list(run_all(itertools.chain.from_iterable(map(round_of, range(rounds)))))
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps([{**asdict(spec), **asdict(one)} for spec, one in found]))
    print(tables(found))
    bad = [(spec, one) for spec, one in found if not one.is_clean]
    for spec, one in bad:
        print(describe(spec, one), file=sys.stderr)
    return [Row("faults", len(bad), "runs", 0, f"of {len(found)} that left something")]


def _check() -> None:
    command = [*ISOLATED, *INIT, "true"]
    try:
        done = subprocess.run(command, stderr=subprocess.DEVNULL, check=False)
    except FileNotFoundError:
        raise NotHereError("no `unshare`") from None
    if done.returncode:
        raise NotHereError("namespaces are not allowed here")


def round_of(number: int) -> list[Spec]:
    """The children are shifted from cell to cell and from round to round."""
    cells = itertools.product(VICTIMS, PHASES, GROUPS)
    kinds = list(KINDS)
    return [
        Spec(victims, phase, kinds[(place + number) % len(kinds)], group, number)
        for place, (victims, phase, group) in enumerate(cells)
    ]


def run_all(specs: Iterable[Spec]) -> Iterable[tuple[Spec, Outcome]]:
    """As they end; as many at the same time as there are processors."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        futures = {pool.submit(run, spec): spec for spec in specs}
        for future in as_completed(futures):
            spec, outcome = futures[future], future.result()
            if not outcome.is_clean:
                print(describe(spec, outcome), file=sys.stderr, flush=True)
            yield spec, outcome


def run(spec: Spec) -> Outcome:
    """One run, in separate namespaces."""
    command = [*ISOLATED, *INIT, sys.executable, "-m", "benchmarks.faults.cell"]
    done = subprocess.run(
        [*command, json.dumps(asdict(spec))],
        cwd=REPOSITORY,
        capture_output=True,
        timeout=CELL_S,
        check=False,
    )
    try:
        return Outcome(**json.loads(done.stdout.splitlines()[-1]))
    except (IndexError, ValueError):
        text = done.stderr.decode(errors="replace")[-1000:]
        return Outcome(hangs=[f"the benchmark itself failed: {text}"])


def describe(spec: Spec, outcome: Outcome) -> str:
    what = {name: value for name, value in asdict(outcome).items() if value and name in COLUMNS}
    return f"{json.dumps(asdict(spec))}: {what}"


# ---- tables


def tables(found: Sequence[tuple[Spec, Outcome]]) -> str:
    """Markdown: one table each by victims, by phase, by child, by control group."""
    views: dict[str, Callable[[Spec], str]] = {
        "killed": lambda spec: " + ".join(spec.victims),
        "during": lambda spec: spec.phase,
        "child of the node": lambda spec: spec.child,
        "control group": lambda spec: spec.group,
    }
    return "\n\n".join(_table(name, view, found) for name, view in views.items())


def _table(name: str, view: Callable[[Spec], str], found: Sequence[tuple[Spec, Outcome]]) -> str:
    head = [name, "runs", *(column.replace("_", " ") for column in COLUMNS)]
    lines = [f"| {' | '.join(head)} |", f"|---{'|--:' * (len(head) - 1)}|"]
    groups: dict[str, list[Outcome]] = {}
    for spec, outcome in sorted(found, key=lambda one: _place(one[0])):
        groups.setdefault(view(spec), []).append(outcome)
    for label, outcomes in groups.items():
        counts = [sum(bool(getattr(one, column)) for one in outcomes) for column in COLUMNS]
        cells = [label, str(len(outcomes)), *map(str, counts)]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _place(spec: Spec) -> tuple[int, ...]:
    return (
        VICTIMS.index(spec.victims),
        PHASES.index(spec.phase),
        list(KINDS).index(spec.child),
        GROUPS.index(spec.group),
    )
