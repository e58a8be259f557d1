"""One compose.yaml, by the Compose specification: a service a process, a profile a host."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from launcher.base.model.spec import RestartMode
from launcher.export.export_model import ExportedFiles, ExportedProcess, ExportedSystem
from launcher.export.exported_system import gaps_of_each
from launcher.export.kubernetes import container_variables
from launcher.export.process_command import (
    FOLDER_IN_IMAGE,
    after,
    cpu_list,
    in_container,
    ulimits,
    without_settings,
)
from launcher.export.yaml_text import document
from launcher.hosts.unit import seconds


class Compose:
    """Writes a Compose file; with `shared_memory` containers share the host's."""

    def __init__(self, system: ExportedSystem, *, image: str, shared_memory: bool = False) -> None:
        self._system = system
        self._image = image
        self._shared_memory = shared_memory

    def output(self) -> ExportedFiles:
        data = {
            "name": self._system.name,
            "services": {one.name: self._service(one) for one in self._system.processes},
        }
        files = {"compose.yaml": document(data)}
        for process in self._system.processes:
            for name, content in process.files.items():
                files[f"files/{name}"] = content.decode(errors="surrogateescape")
        for host, processes in self._system.hosts.items():
            names = sorted({name for process in processes for name in process.private})
            if names:
                files[f"{host}.env.example"] = "".join(f"{name}=\n" for name in names)
        gaps = gaps_of_each(self._system.processes, _gaps)
        return ExportedFiles(files=files, gaps=tuple(gaps))

    def _service(self, process: ExportedProcess) -> dict[str, Any]:
        words = in_container(process, without_settings(process.limits))
        variables = container_variables(process, self._shared_memory)
        service: dict[str, Any] = {
            "image": self._image,
            "profiles": [process.host_name] if self._system.has_hosts else None,
            "network_mode": "host",
            "ipc": "host" if self._shared_memory else None,
            "init": None if process.is_node else True,
            "command": [_literal(word) for word in after(process.delay_s, words)],
            "environment": {name: _literal(value) for name, value in variables.items()},
            "env_file": [f"{process.host_name}.env"] if process.private else None,
            "working_dir": process.cwd,
            "tty": process.tty or None,
            "volumes": [f"./files/{name}:{FOLDER_IN_IMAGE}/{name}:ro" for name in process.files],
            "cpuset": cpu_list(process.limits.cpus) if process.limits.cpus is not None else None,
            "ulimits": _ulimits(process),
            "restart": _restart(process),
            "stop_signal": process.stop.steps[0][0].name,
            "stop_grace_period": seconds(max(process.stop.grace_s, 1.0)),
        }
        return {key: value for key, value in service.items() if value not in (None, [], {})}


def _literal(text: str) -> str:
    """Compose replaces variables; `$$` is a dollar."""
    return text.replace("$", "$$")


def _ulimits(process: ExportedProcess) -> dict[str, dict[str, int]]:
    return {name: {"soft": soft, "hard": hard} for name, soft, hard in ulimits(process.limits)}


def _restart(process: ExportedProcess) -> str:
    policy = process.restart
    if policy.mode is RestartMode.NEVER or policy.max_restarts == 0:
        return "no"
    if policy.mode is RestartMode.ALWAYS:
        return "always"
    return "on-failure" if policy.max_restarts is None else f"on-failure:{policy.max_restarts}"


def _gaps(process: ExportedProcess) -> Iterator[tuple[str, str, bool]]:
    restart = process.restart
    if restart.mode is not RestartMode.NEVER:
        is_limited = restart.max_restarts is not None
        if is_limited and (restart.mode is RestartMode.ALWAYS or restart.window_s is not None):
            yield (
                "restart limit",
                "Compose limits only restarts after failures, without a window",
                False,
            )
        if restart.delay_s or restart.backoff_max_s is not None:
            yield "restart delay", "the container engine chooses the delay", True
        if process.delay_s:
            yield "delayed start", "it is delayed before each restart as well", True
