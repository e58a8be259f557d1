"""From a plan to what is exported."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from launcher.base.model.parameter_text import file_text
from launcher.base.model.record import replace
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import Limits, ProcessSpec
from launcher.export.discovery_variables import gaps as discovery_gaps
from launcher.export.discovery_variables import with_discovery
from launcher.export.export_model import ExportedProcess, ExportedSystem, Unsupported
from launcher.export.exported_command import ExportedCommand
from launcher.export.exported_variables import divided, looks_secret
from launcher.export.unit_names import Name, name_of_system, names_of
from launcher.export.unsupported import Places, gaps_of, is_exported, settings_gaps
from launcher.hosts.file.hosts_model import Discovery, Host
from launcher.hosts.file.order import order_for
from launcher.hosts.unit import stem_of

if TYPE_CHECKING:
    from launcher.launch.plan.plan import Plan, PlannedProcess

HostOf = Callable[[ProcessSpec], Host | None]


def system_of(
    plan: Plan,
    *,
    host_of: HostOf,
    options: RunOptions,
    command: str,
    prefix: str = "",
    discovery: Discovery | None = None,
) -> ExportedSystem:
    """What the plan starts, on the hosts where it is placed; UsageError of `host_of`.

    `options` are those about processes, `command` is the command line, for the README; names of
    units and of Kubernetes objects begin with `prefix`.
    """
    places = Places(plan.path)
    numbers = [n for n, process in enumerate(plan.processes) if is_exported(process)]
    planned = [plan.processes[number] for number in numbers]
    specs = [options.adapt(process.spec) for process in planned]
    names = names_of(specs, prefix)
    made = [
        _process(plan, process, spec, name, host_of(spec), places)
        for process, spec, name in zip(planned, specs, names, strict=True)
    ]
    own = name_of_system(stem_of(plan.path), prefix)
    units = {number: name.unit for number, name in zip(numbers, names, strict=True)}
    processes = [process for process, _ in made]
    gaps = [
        *gaps_of(plan, places, units),
        *(gap for _, gaps in made for gap in gaps),
        *settings_gaps(options, zip(specs, (name.unit for name in names), strict=True), places),
        *discovery_gaps(processes, discovery or Discovery()),
    ]
    return ExportedSystem(
        name=own.label,
        unit=own.unit,
        processes=with_discovery(processes, discovery or Discovery()),
        command=command,
        gaps=merged(gaps),
    )


def merged(gaps: Iterable[Unsupported]) -> tuple[Unsupported, ...]:
    """The gaps without repetitions: those that differ only in processes and places become one."""
    found: dict[tuple[str, str], list[Unsupported]] = {}
    for gap in gaps:
        key = (gap.what, gap.text if gap.names else f"{gap.place}: {gap.text}")
        found.setdefault(key, []).append(gap)
    return tuple(map(_together, found.values()))


def _together(gaps: Sequence[Unsupported]) -> Unsupported:
    places = dict.fromkeys(gap.place for gap in gaps)
    names = dict.fromkeys(name for gap in gaps for name in gap.names)
    return replace(gaps[0], place=", ".join(places), names=tuple(names))


def _process(
    plan: Plan,
    planned: PlannedProcess,
    spec: ProcessSpec,
    name: Name,
    host: Host | None,
    places: Places,
) -> tuple[ExportedProcess, list[Unsupported]]:
    warnings: list[str] = []
    with with_generated_files(spec) as complete:
        order = order_for(complete, base=plan.environment, warn=warnings.append)
    command = ExportedCommand(order, spec, name.unit)
    environment, private = divided(
        order.environment,
        host.environment if host else {},
        {*filter(looks_secret, order.variables), *(host.secrets if host else ())},
    )
    process = ExportedProcess(
        unit=name.unit,
        name=name.label,
        label=spec.label,
        host=host,
        words=command.words,
        files=command.files,
        environment=environment,
        unset=order.unset,
        private=private,
        cwd=None if command.is_order else order.cwd,
        shell=order.shell and not command.is_order,
        tty=order.emulate_tty,
        node=_node(spec),
        package=spec.ros.package if spec.ros else None,
        is_node=spec.ros is not None,
        delay_s=planned.stamp.time_s,
        restart=order.restart,
        stop=order.stop,
        limits=order.limits or Limits(),
        place=places.of_text(spec.place),
    )
    return process, list(_process_gaps(process, spec, command, warnings))


@contextlib.contextmanager
def with_generated_files(spec: ProcessSpec) -> Iterator[ProcessSpec]:
    """The spec with the parameter files of a run, which the end of the dry run has removed."""
    files = [s for s in (spec.ros.parameters if spec.ros else ()) if s.generated is not None]
    with tempfile.TemporaryDirectory(prefix="launcher-export-") as folder:
        paths: dict[str | None, str] = {}
        for number, source in enumerate(files):
            paths[source.file] = os.path.join(folder, str(number), "params.yaml")
            os.mkdir(os.path.dirname(paths[source.file]))
            text = file_text(source.generated)
            with open(paths[source.file], "w", encoding="utf-8", errors="surrogateescape") as file:
                file.write(text)
        yield replace(spec, argv=tuple(paths.get(word, word) for word in spec.argv))


def _node(spec: ProcessSpec) -> str | None:
    ros = spec.ros
    if ros is None or ros.node_name is None:
        return None
    return f"{(ros.namespace or '').rstrip('/')}/{ros.node_name}"


def _process_gaps(
    process: ExportedProcess, spec: ProcessSpec, command: ExportedCommand, warnings: Iterable[str]
) -> Iterator[Unsupported]:
    names = (process.unit,)
    if command.left_out is not None:
        text = "left out: nobody sees it where the process will run"
        yield Unsupported(
            what=f"prefix '{command.left_out}'", place=process.place, text=text, names=names
        )
    for path in command.paths:
        text = f"a parameter file has a path of this machine: {path}"
        yield Unsupported(what="path", place=process.place, text=text, names=names)
    for warning in warnings:
        text = warning.removeprefix(f"{spec.place}: {spec.name}: ")
        yield Unsupported(what="path", place=process.place, text=text, names=names)


def gaps_of_each(
    processes: Sequence[ExportedProcess],
    texts: Callable[[ExportedProcess], Iterator[tuple[str, str, bool]]],
) -> Iterator[Unsupported]:
    """Gaps of single processes; `texts` gives (what, text, whether it is only a note)."""
    for process in processes:
        for what, text, is_note in texts(process):
            yield Unsupported(
                what=what, place=process.place, text=text, names=(process.unit,), is_note=is_note
            )
