"""The README.md of an export: what was exported, the commands to use it, and what is missing."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from launcher.export.export_model import NO_HOST
from launcher.export.kubernetes import runs_on, secret_of
from launcher.export.systemd import python_of
from launcher.hosts.ssh import SYNCED_PYTHON

if TYPE_CHECKING:
    from launcher.export.export_model import ExportedProcess, ExportedSystem, Unsupported
    from launcher.export.image import Image


def readme(
    engine: str,
    system: ExportedSystem,
    image: Image | None,
    gaps: Sequence[Unsupported],
    *,
    python: str,
) -> str:
    sections = [
        f"# {system.unit} for {engine}\n\nMade by `{system.command}`.\n",
        _processes(system, engine),
        *_image(engine, image),
        *_private(system, engine),
        *_WRITERS[engine](system, python),
        *_gaps(gaps),
        f"## In general\n\n{_GENERAL[engine]}",
    ]
    return "\n".join(sections)


_GENERAL = {
    "systemd": """\
All processes start together, those with a timer later. Their output is in the journal, whatever the
launch file says about it. `systemctl stop` sends the first signal of the launch file's stop policy
to all processes of a unit, and SIGKILL when its time is over; stopping the target returns before
its units have stopped.
""",
    "kubernetes": """\
Containers have the network of their node, since DDS needs it. Each has a separate /dev/shm and must
not use shared memory: a node with the same address and another /dev/shm loses all messages.
Until the ROS graph shows its node a pod is not ready; later a process counts as healthy as long as
it runs. The image's STOPSIGNAL must be SIGINT.
""",
    "compose": """\
`podman-compose` takes the same words as `docker compose`.

All services have the network of their machine, since DDS needs it. Each has a separate /dev/shm
and must not use shared memory: a node with the same address and another /dev/shm loses all
messages.
""",
    "podman": """\
Podman 4.4 or newer makes services of the `.container` files; an older one runs what
`export kubernetes` writes, with `podman kube play`. Containers have the network of their machine,
since DDS needs it. Each has a separate /dev/shm and must not use shared memory: a node with the
same address and another /dev/shm loses all messages.
""",
}


def _processes(system: ExportedSystem, engine: str) -> str:
    is_unit = engine in ("systemd", "podman")
    rows = ["| process | name | host | start |", "|---|---|---|---|"]
    for one in system.processes:
        start = f"after {one.delay_s:g} s" if one.delay_s else "at once"
        name = one.unit if is_unit else one.name
        host = _cell(one.host_name) if system.has_hosts else ""
        rows.append(f"| {_cell(one.label)} | `{name}` | {host} | {start} |")
    if system.has_hosts and NO_HOST in system.hosts:
        rows += ["", _LOCAL + (_IN_CLUSTER if engine == "kubernetes" else "")]
    return "\n".join([*rows, ""])


_LOCAL = f"`{NO_HOST}` is the machine that is none of the hosts of the hosts file."
_IN_CLUSTER = " In a cluster its processes run on any node."


def _on(system: ExportedSystem, host: str) -> str:
    return f"on {host}" if system.has_hosts else "on the machine"


def _where(system: ExportedSystem, host: str) -> str:
    folder = system.path_of(host, "")
    return f"As root, in the folder `{folder.rstrip('/')}`:" if folder else "As root:"


def _title(system: ExportedSystem, host: str) -> str:
    return f"O{_on(system, host)[1:]}"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _block(title: str, lines: Iterable[str], text: str = "") -> str:
    before = f"\n{text}\n" if text else ""
    return "\n".join([f"## {title}\n{before}", "```", *lines, "```", ""])


# ---- engines


def _systemd(system: ExportedSystem, python: str) -> Iterator[str]:
    yield f"## The launcher\n\n{_needed(system, python)}\n"
    for host, processes in system.hosts.items():
        units = [name for one in processes for name in _units_of(one)]
        enabled = [
            f"{one.unit}.timer" if one.delay_s else f"{one.unit}.service" for one in processes
        ]
        target = f"{system.unit}.target"
        lines = [
            *_copy_files(system, processes),
            f"install -m 644 {shlex.join([*units, target])} /etc/systemd/system/",
            "systemctl daemon-reload",
            f"systemctl enable {shlex.join([*enabled, target])}",
            f"systemctl start {shlex.quote(target)}",
            f"journalctl -f -u {shlex.quote(processes[0].unit)}",
            f"systemctl stop {shlex.quote(target)}",
        ]
        yield _block(_title(system, host), lines, _where(system, host))


def _needed(system: ExportedSystem, python: str) -> str:
    """What has to be there before the units are started."""
    hosts = {one.host.name: python_of(one.host) for one in system.processes if one.host}
    brought = [name for name, path in hosts.items() if path.endswith(SYNCED_PYTHON)]
    others = [f"`{path}` on {name}" for name, path in hosts.items() if name not in brought]
    if any(one.host is None for one in system.processes):
        others.append(f"`{python}` {_on(system, NO_HOST)}")
    texts = []
    if brought:
        texts.append(
            f"On {', '.join(brought)} the launcher and the packages are those that `launcher hosts "
            "sync` brings: run it first. Another interpreter can be named by `python` in the hosts "
            "file."
        )
    if others:
        texts.append(f"The launcher and the packages must be installed for {', '.join(others)}.")
    return " ".join(texts)


def _units_of(process: ExportedProcess) -> list[str]:
    return [f"{process.unit}.service", *([f"{process.unit}.timer"] if process.delay_s else [])]


def _copy_files(system: ExportedSystem, processes: Sequence[ExportedProcess]) -> Iterator[str]:
    folder = f"/etc/launcher/{system.unit}"
    if any(process.files for process in processes):
        yield f"install -d {folder}/files"
        yield f"install -m 644 files/* {folder}/files/"
    if any(process.private for process in processes):
        yield f"install -D -m 600 {system.unit}.env {folder}/{system.unit}.env"


def _kubernetes(system: ExportedSystem, python: str) -> Iterator[str]:
    first = system.processes[0]
    kind = "deploy" if runs_on(first) else "pod"
    lines = ["kubectl apply -k .", f"kubectl logs -f {kind}/{first.name}", "kubectl delete -k ."]
    yield _block("In a cluster", lines)
    for host, processes in system.hosts.items():
        names = [f"manifests/{one.name}.yaml" for one in processes]
        files = "manifests/*.yaml" if len(system.hosts) == 1 else shlex.join(names)
        play = [
            f"for file in {files}; do podman kube play $file & done; wait",
            f"podman pod logs -f $(podman pod ps --quiet --filter name={processes[0].name})",
            f"for file in {files}; do podman kube down $file; done",
        ]
        yield _block(f"With podman, {_on(system, host)}", play)


def _compose(system: ExportedSystem, python: str) -> Iterator[str]:
    if system.has_hosts:
        yield _PROFILES
    for host, processes in system.hosts.items():
        command = f"docker compose --profile {host}" if system.has_hosts else "docker compose"
        lines = [
            f"{command} up --detach",
            f"{command} logs -f {processes[0].name}",
            f"{command} down",
        ]
        yield _block(_title(system, host) if system.has_hosts else "Start and stop", lines)


_PROFILES = """\
## Profiles

The services of a host have its name as their profile: each machine starts those of its profile, and
without a profile nothing is started.
"""


def _podman(system: ExportedSystem, python: str) -> Iterator[str]:
    for host, processes in system.hosts.items():
        target = f"{system.unit}.target"
        timers = [f"{one.unit}.timer" for one in processes if one.delay_s]
        containers = [f"{one.unit}.container" for one in processes]
        lines = [
            *_copy_files(system, processes),
            f"install -m 644 {shlex.join(containers)} /etc/containers/systemd/",
            f"install -m 644 {shlex.join([*timers, target])} /etc/systemd/system/",
            "systemctl daemon-reload",
            f"systemctl enable --now {shlex.join([*timers, target])}",
            f"journalctl -f -u {shlex.quote(processes[0].unit)}",
            f"systemctl stop {shlex.quote(target)}",
        ]
        yield _block(_title(system, host), lines, _where(system, host))


_WRITERS = {
    "systemd": _systemd,
    "kubernetes": _kubernetes,
    "compose": _compose,
    "podman": _podman,
}


# ---- image, variables, gaps


_OWN_IMAGE = """\
## The image

The containers are of an image of your own, which must have the launcher and the packages, for its
`python3`.
"""


def _image(engine: str, image: Image | None) -> Iterator[str]:
    """How to build the image of the recipe; None is one of the user."""
    if image is not None:
        yield _recipe(image)
    elif engine != "systemd":
        yield _OWN_IMAGE


def _recipe(image: Image) -> str:
    from launcher.export.image import build_commands

    text = (
        "`image/` is the build context. `image/wheels/` takes the packages that are in no index "
        "as wheels: `pip wheel` makes them from a source folder, `launcher wheel` from a "
        "workspace. The versions of the others are those with which this was exported."
    )
    if image.missing:
        names = ", ".join(f"`{name}`" for name in image.missing)
        text += f" **Not in the image:** {names}, which are of an installation of ROS 2."
    return _block("The image", build_commands(image), text)


def _private(system: ExportedSystem, engine: str) -> Iterator[str]:
    """How to set variables whose values are not written."""
    having = [process for process in system.processes if process.private]
    if not having:
        return
    names = ", ".join(f"`{name}`" for name in sorted({n for one in having for n in one.private}))
    text = f"The values of {names} are not written, since they may be secret."
    if engine == "kubernetes":
        lines = list(_secret_commands(having))
    else:
        lines = sorted({_example_command(process, system, engine) for process in having})
    where = "" if engine == "kubernetes" else ", in the folder of this file"
    yield _block("Private variables", lines, f"{text} Set them before the start{where}:")
    if engine == "kubernetes":
        play = [_AS_JSON, *(_play_secret(process) for process in having)]
        yield _block("Private variables with podman", play, _OF_PODMAN)


def _secret_commands(having: Sequence[ExportedProcess]) -> Iterator[str]:
    """By files: other users can read the words of a command, and so can the shell's history."""
    for process in having:
        path = f"{secret_of(process)}.env"
        names = " ".join(f"{name}=" for name in process.private)
        yield f"(umask 077 && printf '%s\\n' {names} >{path}) && editor {path}"
        yield f"kubectl create secret generic {secret_of(process)} --from-env-file={path}"
        yield f"rm {path}"


_OF_PODMAN = """\
`podman kube play` 4.3 takes them from a secret of podman, which is JSON with the values in base64.
This is in place of `kubectl create secret`, on the machine where the process is to run:"""
_AS_JSON = """\
as_json() { python3 -c 'import base64, json, sys
pairs = [line.rstrip("\\n").partition("=") for line in sys.stdin if "=" in line]
print(json.dumps({name: base64.b64encode(value.encode()).decode() for name, _, value in pairs}))'
}"""


def _play_secret(process: ExportedProcess) -> str:
    name = secret_of(process)
    return f"as_json <{name}.env | podman secret create {name} -"


def _example_command(process: ExportedProcess, system: ExportedSystem, engine: str) -> str:
    path = system.path_of(process.host_name, f"{system.unit}.env")
    path = f"{process.host_name}.env" if engine == "compose" else path
    return f"cp {path}.example {path} && chmod 600 {path} && editor {path}"


def _gaps(gaps: Sequence[Unsupported]) -> Iterator[str]:
    lost = [f"* {_plain(gap.line)}" for gap in gaps if not gap.is_note]
    notes = [f"* {_plain(gap.line)}" for gap in gaps if gap.is_note]
    if lost:
        yield "\n".join(["## Not exported\n", *lost, ""])
    if notes:
        yield "\n".join(["## Different\n", *notes, ""])


def _plain(text: str) -> str:
    return text.replace("*", "\\*").replace("<", "&lt;")
