"""Quadlet files for Podman 4.4 or newer: systemd units of containers, a folder per host."""

from __future__ import annotations

import shlex
from collections.abc import Iterator

from launcher.export.export_model import ExportedProcess, ExportedSystem
from launcher.export.kubernetes import container_variables
from launcher.export.process_command import (
    FOLDER_IN_IMAGE,
    cpu_list,
    in_container,
    ulimits,
    without_settings,
)
from launcher.export.systemd import Systemd, policy_gaps, unit_text
from launcher.hosts import unit

FOLDER = "/etc/containers/systemd"


class Quadlet(Systemd):
    """Writes `.container` files; with `shared_memory` containers share the host's."""

    ending = "container"

    def __init__(self, system: ExportedSystem, *, image: str, shared_memory: bool = False) -> None:
        super().__init__(system)
        self._image = image
        self._shared_memory = shared_memory

    def _service(self, process: ExportedProcess) -> str:
        known, _ = unit.supported(unit.restart_settings(process.restart), unit.OLDEST)
        of_unit = [(one.key, one.value) for one in known if one.section == "Unit"]
        of_service = [(one.key, one.value) for one in known if one.section == "Service"]
        # Podman itself ends a container that has not stopped by then.
        stop_s = unit.seconds(process.stop.grace_s + 10.0)
        return unit_text(
            ("Unit", [*self._unit_entries(process), *of_unit]),
            ("Container", list(self._entries(process))),
            ("Service", [*of_service, ("TimeoutStopSec", stop_s)]),
            ("Install", self._install_entries(process)),
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
            yield "EnvironmentFile", f"{self.folder}/{self._system.unit}.env"
        for name in process.files:
            yield "Volume", f"{self.folder}/files/{name}:{FOLDER_IN_IMAGE}/{name}:ro"
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

    def _gaps(self, process: ExportedProcess) -> Iterator[tuple[str, str, bool]]:
        return policy_gaps(process)
