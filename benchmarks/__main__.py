"""`python -m benchmarks [NAME ...] [--runs N] [--check]`: measure, print the table."""

from __future__ import annotations

import argparse
import os
import platform
import signal
import sys
from collections.abc import Callable, Sequence

from benchmarks import bag_limits, bags, hosts, web, web_load
from benchmarks.building import building
from benchmarks.console import console
from benchmarks.crowd import crowd
from benchmarks.faults.matrix import faults
from benchmarks.footprint import footprint
from benchmarks.harness import NotHereError, Row
from benchmarks.large import large
from benchmarks.latency import latency
from benchmarks.mutants import mutants
from benchmarks.mutants.mutations import MUTANTS
from benchmarks.plan import plan
from benchmarks.process_table import process_table
from benchmarks.restarts import first_restart, respawn
from benchmarks.ros.first_answers import first_answers
from benchmarks.ros.own_types import own_types
from benchmarks.ros.verbs import topic_list, topic_stream
from benchmarks.sampling import sampling
from benchmarks.startup import fifty, first_exec, from_shell, many_execs
from benchmarks.stopping import ctrl_c
from benchmarks.terminal import terminal
from benchmarks.throughput import pipes, ptys
from benchmarks.verb_costs import verbs
from benchmarks.warm import discovery, hundred, saving, starts
from benchmarks.watched.cost import watching
from benchmarks.watched.trials import injected_faults

BENCHMARKS: dict[str, Callable[[int], list[Row]]] = {
    "first": first_exec,
    "many": many_execs,
    "fifty": fifty,
    "pipes": pipes,
    "ptys": ptys,
    "latency": latency,
    "console": console,
    "terminal": terminal,
    "idle": footprint,
    "crowd": crowd,
    "sampling": sampling,
    "process-table": process_table,
    "respawn": respawn,
    "first-restart": first_restart,
    "ctrl-c": ctrl_c,
    "plan": plan,
    "verbs": verbs,
    "shell": from_shell,
    "large": large,
    "building": building,
    "topic-list": topic_list,
    "topic-stream": topic_stream,
    "first-answers": first_answers,
    "injected-faults": injected_faults,
    "own-types": own_types,
    "discovery-late": discovery.late,
    "discovery-graph": discovery.graph,
    "warm-fleet": starts.fleet,
    "warm-restart": starts.restart,
    "warm-save": saving.save,
    "warm-twenty": starts.twenty,
    "warm-memory": starts.memory,
    "warm-none": starts.without_nodes,
    "warm-hundred": hundred.hundred,
    "bag-record": bags.record,
    "bag-play": bags.play,
    "bag-flight": bags.flight,
    "bag-limit": bag_limits.limit,
    "bag-large": bag_limits.large,
    "web-first": web.first,
    "web-hundred": web.hundred,
    "web-300": web_load.many,
    "web-flood": web.flood,
    "web-tabs": web.tabs,
    "web-day": web_load.day,
    "hosts-first": hosts.first_line,
    "hosts-delay": hosts.delay,
    "hosts-flood": hosts.flood,
    "hosts-fleet": hosts.fleet,
    "hosts-outage": hosts.outage,
    "hosts-scale": hosts.scale,
    "hosts-units": hosts.units,
    "hosts-slow-link": hosts.slow_link,
    "watching": watching,
    "faults": faults,
    "mutants": mutants,
}
ON_REQUEST = {"faults", "mutants"}  # half an hour
ALWAYS_CHECKED = {"mutants"}  # no figure depends on the machine
GROUPS = {
    group: [name for name in BENCHMARKS if name.startswith(f"{group}-")]
    for group in ("bag", "hosts", "warm", "web")
}
GROUPS["warm"] += ["fifty", "first-restart", "terminal", "idle", "crowd"]
HEAD = ("what", "measured", "limit", "", "details")


def main(words: Sequence[str]) -> int:
    """Run the named benchmarks, or all; 1 if a limit is exceeded and checked."""
    options = _parser().parse_args(words)
    unknown = set(options.names) - BENCHMARKS.keys() - GROUPS.keys()
    if unknown:
        _parser().error(f"no benchmark {', '.join(sorted(unknown))}")
    names = [one for name in options.names for one in GROUPS.get(name, [name])]
    if options.only and names != ["mutants"]:
        _parser().error("--only needs mutants")
    if unfit := set(options.only or ()) - {mutant.name for mutant in MUTANTS}:
        _parser().error(f"no mutant {', '.join(sorted(unfit))}")
    print(_machine(), flush=True)
    # `command &` in a shell script ignores SIGINT, which every process below would inherit.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rows: list[Row] = []
    code = 0
    for name in names or [one for one in BENCHMARKS if one not in ON_REQUEST]:
        print(f"measuring {name} ...", file=sys.stderr, flush=True)
        for row in _measured(name, options.runs, options.only):
            print(*row.cells(), sep="  ", file=sys.stderr, flush=True)
            rows.append(row)
            if (options.check or name in ALWAYS_CHECKED) and not row.is_met:
                code = 1
    print(_table(rows))
    print(_machine())
    return code


def _measured(name: str, runs: int, only: Sequence[str]) -> list[Row]:
    try:
        return mutants(runs, only) if only else BENCHMARKS[name](runs)
    except NotHereError as error:
        print(f"not measured: {error}", file=sys.stderr, flush=True)
        return []


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join((*BENCHMARKS, *GROUPS)))
    parser.add_argument("--runs", type=int, default=7, help="measurements of each (7)")
    parser.add_argument("--only", action="append", metavar="NAME", help="of the mutants, this one")
    parser.add_argument("--check", action="store_true", help="exit with 1 if a limit is exceeded")
    return parser


def _machine() -> str:
    load = ", ".join(f"{value:.2f}" for value in os.getloadavg())
    return f"Python {platform.python_version()}, {os.cpu_count()} cores, load {load}"


def _table(rows: Sequence[Row]) -> str:
    """A Markdown table with aligned columns."""
    cells = [HEAD, *(row.cells() for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [
        f"| {' | '.join(c.ljust(w) for c, w in zip(line, widths, strict=True))} |" for line in cells
    ]
    lines.insert(1, f"|{'|'.join('-' * (width + 2) for width in widths)}|")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
