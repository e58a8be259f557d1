"""Quadlet files for Podman 4.4 or newer: systemd units of containers, a folder per host."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence

from launcher.export.command import (
    FOLDER_IN_IMAGE,
    cpu_list,
    in_container,
    ulimits,
    without_settings,
)
from launcher.export.kubernetes import container_variables
from launcher.export.model import ExportedFiles, ExportedProcess, ExportedSystem
from launcher.export.system import gaps_of_each
from launcher.export.systemd import Systemd, policy_gaps, unit_text
from launcher.hosts import unit

FOLDER = "/etc/containers/systemd"


class Quadlet:
    """Writes `.container` files; with `shared_memory` containers share the host's."""

    def __init__(self, system: ExportedSystem, *, image: str, shared_memory: bool = False) -> None:
        self._system = system
        self._image = image
        self._shared_memory = shared_memory
        self._units = Systemd(system)

    def output(self) -> ExportedFiles:
        files: dict[str, str] = {}
        for host, processes in self._system.hosts.items():
            for name, text in self._of_host(processes):
                files[self._system.path_of(host, name)] = text
        gaps = gaps_of_each(self._system.processes, _gaps)
        return ExportedFiles(files=files, gaps=tuple(gaps))

    def _of_host(self, processes: Sequence[ExportedProcess]) -> Iterator[tuple[str, str]]:
        yield from self._units.beside_services(processes)
        for process in processes:
            yield f"{process.unit}.container", self._container(process)

    def _container(self, process: ExportedProcess) -> str:
        known, _ = unit.supported(unit.restart_settings(process.restart), unit.OLDEST)
        of_unit = [(one.key, one.value) for one in known if one.section == "Unit"]
        of_service = [(one.key, one.value) for one in known if one.section == "Service"]
        # Podman itself ends a container that has not stopped by then.
        stop_s = unit.seconds(process.stop.grace_s + 10.0)
        return unit_text(
            ("Unit", [*self._units.unit_entries(process), *of_unit]),
            ("Container", list(self._entries(process))),
            ("Service", [*of_service, ("TimeoutStopSec", stop_s)]),
            ("Install", self._units.install_entries(process)),
        )

    def _entries(self, process: ExportedProcess) -> Iterator[tuple[str, str]]:
        yield "Image", self._image
        yield "ContainerName", process.unit
        yield "Network", "host"
        if not process.is_node:
            yield "RunInit", "true"
        for name, value in container_variables(process, self._shared_memory).items():
            yield "Environment", unit.exec_line([f"{name}={value}"])
        if process.private:
            yield "EnvironmentFile", f"{self._units.folder}/{self._system.unit}.env"
        for name in process.files:
            yield "Volume", f"{self._units.folder}/files/{name}:{FOLDER_IN_IMAGE}/{name}:ro"
        yield "PodmanArgs", shlex.join(self._podman_words(process)).replace("%", "%%")
        yield "Exec", unit.exec_line(in_container(process, without_settings(process.limits)))

    def _podman_words(self, process: ExportedProcess) -> Iterator[str]:
        """Options that `.container` files have no key for in every version of Podman."""
        yield f"--stop-signal={process.stop.steps[0][0].name}"
        yield f"--stop-timeout={max(1, round(process.stop.grace_s))}"
        if self._shared_memory:
            yield "--ipc=host"
        if process.tty:
            yield "--tty"
        if process.cwd is not None:
            yield f"--workdir={process.cwd}"
        if process.limits.cpus is not None:
            yield f"--cpuset-cpus={cpu_list(process.limits.cpus)}"
        for name, soft, hard in ulimits(process.limits):
            yield f"--ulimit={name}={soft}:{hard}"


def _gaps(process: ExportedProcess) -> Iterator[tuple[str, str, bool]]:
    yield from policy_gaps(process)
