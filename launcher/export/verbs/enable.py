"""`launch --enable`, `--disable`: units of a launch file on its hosts, started at boot."""

from __future__ import annotations

import os
import sys

from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.base.model.record import replace
from launcher.base.model.run_options import RunOptions
from launcher.export.export_model import NO_HOST, ExportedProcess, ExportedSystem
from launcher.export.exported_system import system_of
from launcher.export.systemd import Systemd
from launcher.export.verbs.export import evaluated
from launcher.hosts import unit
from launcher.hosts.engine.systemd.unit_installer import Installer
from launcher.hosts.file.hosts_model import Host, HostsFile
from launcher.hosts.file.hosts_reader import read
from launcher.hosts.file.option_changes import changed
from launcher.hosts.file.placement import Placement
from launcher.launch.target import LaunchRequest


def enable(request: LaunchRequest, options: RunOptions) -> int:
    """Install the processes of other hosts there; nothing is started on this machine."""
    file = _hosts_file(options)
    system = _system(request, options, file)
    code = ExitCode.OK
    for gap in (*system.gaps, *Systemd(system).output().gaps):
        if gap.what not in ("user", "emulate_tty"):
            print(f"{'note' if gap.is_note else 'not installed'}: {gap.line}", file=sys.stderr)
    for name, processes in system.hosts.items():
        labels = ", ".join(process.label for process in processes)
        if name == NO_HOST:
            print(f"not installed, since they run on this machine: {labels}")
            continue
        if file.hosts[name].is_skipped:
            print(f"{name}: skipped; left as it is: {labels}")
            continue
        try:
            _install(system, file.hosts[name], processes)
        except LauncherError as error:
            print(error.render(), file=sys.stderr)
            code = ExitCode.PROCESS_FAILED
        else:
            print(f"{name}: {labels} started, and enabled for boot: {system.unit}.target")
    return code


def disable(request: LaunchRequest, options: RunOptions) -> int:
    """Stop and remove what `enable` has installed, on all hosts of the hosts file."""
    name, code = _name(request), ExitCode.OK
    for host in _hosts_file(options).hosts.values():
        if host.is_skipped:
            print(f"{host.name}: skipped; left as it is")
            continue
        try:
            was_there = Installer(host).remove(name)
        except LauncherError as error:
            print(error.render(), file=sys.stderr)
            code = ExitCode.PROCESS_FAILED
        else:
            print(f"{host.name}: {'stopped and removed' if was_there else 'nothing installed'}")
    return code


def _hosts_file(options: RunOptions) -> HostsFile:
    if options.hosts is None:
        raise UsageError("--enable and --disable need --hosts FILE")
    return changed(read(options.hosts), options.discovery, options.skip_hosts)


def _name(request: LaunchRequest) -> str:
    return unit.installed_name(request.path)


def _system(request: LaunchRequest, options: RunOptions, file: HostsFile) -> ExportedSystem:
    system = system_of(
        evaluated(request, file),
        host_of=Placement(file).host_of,
        options=options,
        command=f"launcher {os.path.basename(request.path)} --enable",
        prefix=f"{_name(request)}-",
        discovery=file.discovery,
    )
    return replace(system, unit=_name(request))


def _install(system: ExportedSystem, host: Host, processes: list[ExportedProcess]) -> None:
    installer = Installer(host)
    facts = installer.facts
    placed = replace(host, python=facts.python, user=facts.user)
    mine = replace(system, processes=tuple(replace(one, host=placed) for one in processes))
    writer = Systemd(mine, home=facts.home if facts.is_user else None)
    folder = f"{host.name}/"
    files = {
        path.removeprefix(folder): text.encode("utf-8", "surrogateescape")
        for path, text in writer.output().files.items()
        if path.startswith(folder) and not path.endswith(".example")
    }
    started = [f"{one.unit}.{'timer' if one.delay_s else 'service'}" for one in processes]
    secrets = _secrets(host, processes)
    installer.install(mine.unit, files, secrets, [*started, f"{mine.unit}.target"])


def _secrets(host: Host, processes: list[ExportedProcess]) -> bytes:
    """The environment file with the values that are in no unit; LauncherError without a value."""
    names = dict.fromkeys(name for one in processes for name in one.private)
    values = {**os.environ, **host.environment}
    for name in names:
        if name not in values:
            raise LauncherError(f"host '{host.name}': the variable {name} has no value here")
    return unit.environment_file({name: values[name] for name in names}).encode()
