"""Finds the runs that live on hosts, and stops one, without an event loop."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from launcher.base.errors import LauncherError
from launcher.base.model.record import Record
from launcher.hosts.engine.systemd import run_manifest
from launcher.hosts.engine.systemd.host_facts import hello, read_facts
from launcher.hosts.engine.systemd.run_manifest import RunManifest
from launcher.hosts.engine.systemd.scripts import Scripts
from launcher.hosts.file.hosts_model import Host, HostEngine
from launcher.hosts.file.order import Order
from launcher.hosts.ssh import SshConnection
from launcher.hosts.ssh_command import run as run_there

TIMEOUT_S = 20.0
STOP_S = 60.0
_MANIFESTS = r"""
runtime=/run
[ "$(id -u)" = 0 ] || runtime=${XDG_RUNTIME_DIR:-/run/user/$(id -u)}
for file in "$runtime"/launcher/*/manifest; do
  [ -f "$file" ] && cat "$file" && echo
done
exit 0
"""


class FoundRun(Record):
    """A run; `orders` by process id, `host_of` the name of the host by name of process."""

    run: str
    title: str
    operator: str
    started: float
    hosts: Mapping[str, Host]
    host_of: Mapping[str, str]
    orders: Mapping[int, Order]


class FoundRuns(Record):
    """The runs, newest first; `warnings` name hosts that were not asked, with the reason."""

    runs: tuple[FoundRun, ...]
    warnings: tuple[str, ...]


def find(hosts: Sequence[Host]) -> FoundRuns:
    """Ask all hosts at the same time."""
    asked = [host for host in hosts if host.engine is not HostEngine.SSH]
    with ThreadPoolExecutor(max_workers=max(1, len(asked))) as pool:
        answers = list(pool.map(_manifests, asked))
    records = [
        (host, record)
        for host, answer in zip(asked, answers, strict=True)
        if not isinstance(answer, str)
        for record in answer
    ]
    ids = dict.fromkeys(record.run for _, record in records)
    runs = [_joined([(h, r) for h, r in records if r.run == one]) for one in ids]
    newest_first = sorted(runs, key=lambda run: run.started, reverse=True)
    return FoundRuns(tuple(newest_first), tuple(one for one in answers if isinstance(one, str)))


def _manifests(host: Host) -> list[RunManifest] | str:
    """The records of a host, or why there are none."""
    try:
        done = run_there(SshConnection(host, None), _MANIFESTS, timeout_s=TIMEOUT_S)
    except LauncherError as error:
        return f"{error.message}{f'; {error.hint}' if error.hint else ''}"
    found = []
    for line in done.stdout.decode(errors="replace").splitlines():
        try:
            found.append(run_manifest.decode(line))
        except (ValueError, KeyError, TypeError, AttributeError):
            continue  # of another version
    return found


def _joined(records: Sequence[tuple[Host, RunManifest]]) -> FoundRun:
    _, first = records[0]
    return FoundRun(
        run=first.run,
        title=first.title,
        operator=first.operator,
        started=min(record.started for _, record in records),
        hosts={host.name: host for host, _ in records},
        host_of={o.name: host.name for host, record in records for o in record.orders.values()},
        orders={number: o for _, record in records for number, o in record.orders.items()},
    )


def stop(run: FoundRun) -> list[str]:
    """Stop it on all its hosts, and remove its traces; what has failed."""
    with ThreadPoolExecutor(max_workers=len(run.hosts)) as pool:
        failures = pool.map(lambda host: _stop(run, host), run.hosts.values())
        return [failure for failure in failures if failure]


def _stop(run: FoundRun, host: Host) -> str:
    connection = SshConnection(host, None)
    try:
        facts = read_facts(
            run_there(connection, hello(host), timeout_s=TIMEOUT_S).stdout.decode(errors="replace")
        )
        names: Iterable[str] = (n for n, place in run.host_of.items() if place == host.name)
        script = Scripts(run.run, host, facts).finish(names, run_manifest.operator(), at_once=False)
        run_there(connection, script, timeout_s=STOP_S)
    except (LauncherError, KeyError, ValueError) as error:
        return f"{host.name}: {error}"
    return ""
