"""Kubernetes manifests, which `podman kube play` reads as well: one file for each process."""

from __future__ import annotations

import base64
import math
import re
from collections.abc import Container, Iterator, Mapping
from typing import Any

from launcher.base.model.spec import UNLIMITED, Limits, RestartMode
from launcher.export.export_model import ExportedFiles, ExportedProcess, ExportedSystem
from launcher.export.exported_system import gaps_of_each
from launcher.export.process_command import FOLDER_IN_IMAGE, PYTHON_IN_IMAGE, after, in_container
from launcher.export.yaml_text import document, documents

UDP_ONLY = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
_PROBE_PERIOD_S, _PROBE_TIMEOUT_S, _PROBE_FAILURES = 5, 15, 60
_FILES = "files"

Object = dict[str, Any]
_OF_CLUSTER = "KUBERNETES_"  # variables with the address of the cluster, which every pod gets
# What Kubernetes reads at a dollar: an escaped one, or the name of a variable up to the bracket.
_READ = re.compile(r"\$\$|\$\(([^)]*)\)")


class Kubernetes:
    """Writes manifests; with `shared_memory` containers share the host's, instead of UDP only."""

    def __init__(self, system: ExportedSystem, *, image: str, shared_memory: bool = False) -> None:
        self._system = system
        self._image = image
        self._shared_memory = shared_memory

    def output(self) -> ExportedFiles:
        files = {
            f"manifests/{process.name}.yaml": documents(self._objects(process))
            for process in self._system.processes
        }
        kustomization = {
            "apiVersion": "kustomize.config.k8s.io/v1beta1",
            "kind": "Kustomization",
            "resources": list(files),
        }
        gaps = gaps_of_each(self._system.processes, self._gaps)
        files = {"kustomization.yaml": document(kustomization), **files}
        return ExportedFiles(files=files, gaps=tuple(gaps))

    def _objects(self, process: ExportedProcess) -> Iterator[Object]:
        if process.files:
            yield self._config_map(process)
        yield self._deployment(process) if runs_on(process) else self._pod(process)

    # ---- objects

    def _config_map(self, process: ExportedProcess) -> Object:
        texts, others = {}, {}
        for name, content in process.files.items():
            try:
                texts[name] = content.decode()
            except UnicodeDecodeError:
                others[name] = base64.b64encode(content).decode()
        head = {"apiVersion": "v1", "kind": "ConfigMap"}
        data = {"data": texts} if texts else {}
        binary = {"binaryData": others} if others else {}
        return {**head, "metadata": self._metadata(process, f"-{_FILES}"), **data, **binary}

    def _deployment(self, process: ExportedProcess) -> Object:
        return {
            "apiVersion": "apps/v1",
            "kind": "Deployment",
            "metadata": self._metadata(process),
            "spec": {
                "replicas": 1,
                "strategy": {"type": "Recreate"},  # never two nodes of one name
                "selector": {"matchLabels": {_NAME: process.name}},
                "template": {
                    "metadata": {"labels": self._labels(process)},
                    "spec": self._pod_spec(process),
                },
            },
        }

    def _pod(self, process: ExportedProcess) -> Object:
        on_failure = process.restart.mode is RestartMode.ON_FAILURE
        policy = {"restartPolicy": "OnFailure" if on_failure else "Never"}
        return {
            "apiVersion": "v1",
            "kind": "Pod",
            "metadata": self._metadata(process),
            "spec": {**policy, **self._pod_spec(process)},
        }

    def _metadata(self, process: ExportedProcess, suffix: str = "") -> Object:
        return {"name": f"{process.name}{suffix}", "labels": self._labels(process)}

    def _labels(self, process: ExportedProcess) -> dict[str, str]:
        return {
            _NAME: process.name,
            "app.kubernetes.io/part-of": self._system.name,
            "app.kubernetes.io/managed-by": "launcher",
        }

    # ---- the pod

    def _pod_spec(self, process: ExportedProcess) -> Object:
        spec: Object = {
            "hostNetwork": True,
            "dnsPolicy": "ClusterFirstWithHostNet",
            **({"hostIPC": True} if self._shared_memory else {}),
            # The first process of a container gets only signals that it handles.
            **({} if process.is_node else {"shareProcessNamespace": True}),
            "automountServiceAccountToken": False,
            "enableServiceLinks": False,
            "terminationGracePeriodSeconds": max(1, math.ceil(process.stop.grace_s)),
            **_selector(process),
        }
        spec["containers"] = [self._container(process)]
        if process.files:
            source = {"name": f"{process.name}-{_FILES}"}
            spec["volumes"] = [{"name": _FILES, "configMap": source}]
        return spec

    def _container(self, process: ExportedProcess) -> Object:
        container: Object = {
            "name": process.name,
            "image": self._image,
            "imagePullPolicy": "IfNotPresent",
            "command": self._written_command(process),
            "env": list(self._variables(process)),
        }
        if process.cwd is not None:
            container["workingDir"] = process.cwd
        if process.tty:
            container["tty"] = True
        container |= _resources(process.limits)
        if process.files:
            mount = {"name": _FILES, "mountPath": FOLDER_IN_IMAGE, "readOnly": True}
            container["volumeMounts"] = [mount]
        if process.node is not None:
            container["startupProbe"] = _probe(process.node)
        return container

    def _variables(self, process: ExportedProcess) -> Iterator[Object]:
        for name, value in self._written_values(process).items():
            yield {"name": name, "value": value}
        for name in process.private:
            reference = {"name": secret_of(process), "key": name}
            yield {"name": name, "valueFrom": {"secretKeyRef": reference}}

    def _written_values(self, process: ExportedProcess) -> dict[str, str]:
        values = container_variables(process, self._shared_memory)
        names = [*values]  # a value can refer to those before it
        return {name: literal(values[name], names[:i]) for i, name in enumerate(names)}

    def _written_command(self, process: ExportedProcess) -> list[str]:
        known = {*container_variables(process, self._shared_memory), *process.private}
        return [literal(word, known) for word in _command(process)]

    # ---- what it cannot do

    def _gaps(self, process: ExportedProcess) -> Iterator[tuple[str, str, bool]]:
        yield from _gaps(process)
        if self._is_escaped(process):
            text = "`podman kube play` passes on the dollars that Kubernetes removes: two for one"
            yield "dollars", text, True

    def _is_escaped(self, process: ExportedProcess) -> bool:
        """Whether a text has other dollars in the manifest than in the launch file."""
        values = container_variables(process, self._shared_memory)
        is_same = self._written_values(process) == values
        return not is_same or self._written_command(process) != _command(process)


_NAME = "app.kubernetes.io/name"


def runs_on(process: ExportedProcess) -> bool:
    """Whether it is a Deployment: a node, or a program that is always restarted."""
    return process.is_node or process.restart.mode is RestartMode.ALWAYS


def secret_of(process: ExportedProcess) -> str:
    """The name of the Secret with the private variables of a process."""
    return f"{process.name}-environment"


def container_variables(process: ExportedProcess, shared_memory: bool) -> dict[str, str]:
    """Variables of a container: a node with a separate /dev/shm must not use shared memory."""
    return {**({} if shared_memory else UDP_ONLY), **process.environment}


def _command(process: ExportedProcess) -> list[str]:
    return after(process.delay_s, in_container(process, process.limits))


def _selector(process: ExportedProcess) -> Object:
    if process.host is None:
        return {}
    own: Mapping[str, str] = process.host.node_selector
    return {
        "nodeSelector": dict(sorted(own.items())) or {"kubernetes.io/hostname": process.host.name}
    }


def _probe(node: str) -> Object:
    """Until the node is in the ROS graph the pod is not ready; nothing is run after that."""
    return {
        "exec": {"command": [PYTHON_IN_IMAGE, "-m", "launcher", "node", "info", node]},
        "periodSeconds": _PROBE_PERIOD_S,
        "timeoutSeconds": _PROBE_TIMEOUT_S,
        "failureThreshold": _PROBE_FAILURES,
    }


def _resources(limits: Limits) -> Object:
    """The same limits as `taskset` and `prlimit` set, for the scheduler; nothing is reserved."""
    found: dict[str, str] = {}
    if limits.cpus is not None:
        found["cpu"] = str(len(limits.cpus))
    memory = next((soft for name, soft, _ in limits.rlimits if name == "as"), UNLIMITED)
    if memory != UNLIMITED:
        found["memory"] = str(memory)
    none = dict.fromkeys(found, "0")
    return {"resources": {"requests": none, "limits": found}} if found else {}


def _gaps(process: ExportedProcess) -> Iterator[tuple[str, str, bool]]:
    restart = process.restart
    if process.is_node and restart.mode is not RestartMode.ALWAYS:
        what = "when it ends" if restart.mode is RestartMode.NEVER else "also after success"
        yield "no restart", f"a Deployment starts it again {what}", True
    if restart.mode is not RestartMode.NEVER:
        if restart.max_restarts is not None:
            yield "restart limit", "Kubernetes restarts without limit", False
        if restart.delay_s or restart.backoff_max_s is not None:
            text = "Kubernetes restarts at once, then after delays that grow from 10 s to 5 min"
            yield "restart delay", text, True
    if process.delay_s and runs_on(process):
        yield "delayed start", "it is delayed before each restart as well", True
    if process.stop.steps[0][0].name != "SIGINT":
        text = f"the image's signal is sent, SIGINT, instead of {process.stop.steps[0][0].name}"
        yield "stop", text, False
    if process.limits.nice is not None and process.limits.nice < 0:
        yield "nice", "a negative value needs the capability SYS_NICE", False


def literal(text: str, known: Container[str]) -> str:
    """The text for a place where the variables `known` would be replaced.

    Only what Kubernetes would change is escaped, since `podman kube play` replaces nothing and
    removes no escape: `$(date)` stays, where there is no variable `date`.
    """

    def escaped(found: re.Match[str]) -> str:
        name = found[1]
        if name is None:
            return "$$$$"
        is_variable = name in known or name.startswith(_OF_CLUSTER)
        return f"${found[0]}" if is_variable else found[0]

    return _READ.sub(escaped, text)
