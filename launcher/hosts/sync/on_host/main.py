"""Answers the requests of `launcher.hosts.sync.sync_session`, one after the other."""

from __future__ import annotations

import os
import platform
import signal
import sys

from launcher.hosts.sync.on_host import environment, releases, wire
from launcher.hosts.sync.on_host.store import HostStore, Refusal, disk_errors

TYPE_CHECKING = False
if TYPE_CHECKING:
    from io import BufferedReader
    from typing import Any, BinaryIO


_SILENCE_S = 60  # a link that is down is not noticed otherwise, and would keep the lock


class SyncService:
    def __init__(self, requests: Requests, answers: BinaryIO) -> None:
        self._requests = requests
        self._answers = answers
        self._workspace = HostStore("")

    def run(self) -> None:
        """Until the operator closes the connection."""
        while True:
            request = wire.receive(self._requests)
            try:
                with disk_errors(self._workspace):
                    answer = getattr(self, f"_do_{request['do']}")(request)
            except Refusal as refusal:
                answer = {"error": str(refusal), "hint": refusal.hint}
            if answer is not None:
                wire.send(self._answers, answer)
            if answer is not None and "error" in answer:
                return

    def _say(self, text: str) -> None:
        wire.send(self._answers, {"say": text})

    def _do_facts(self, request: dict[str, Any]) -> dict[str, Any]:
        root = os.path.expanduser(request["workspace"])
        self._workspace = HostStore(os.path.join(os.path.realpath(os.getcwd()), root))
        return facts(self._workspace)

    def _do_lock(self, request: dict[str, Any]) -> dict[str, Any]:
        self._workspace.lock(self._say)
        self._workspace.sign(request["who"])
        self._requests.limited = True
        current = self._workspace.current_release()
        return {"id": releases.identity(self._workspace, current), "current": current}

    def _do_compare(self, request: dict[str, Any]) -> dict[str, Any]:
        """What would be different: paths that are new, changed and gone."""
        name = self._workspace.current_release()
        files = {} if name is None else self._workspace.record(name).get("files", {})
        damaged = set() if name is None else self._workspace.changed_files(name)
        new = {path: value for kind, path, value, _ in request["entries"] if kind == "file"}
        return {
            "new": sorted(path for path in new if path not in files),
            "changed": sorted(
                path
                for path, digest in new.items()
                if path in files and (files[path][0] != digest or path in damaged)
            ),
            "gone": sorted(path for path in files if path not in new),
            "missing": releases.missing(self._workspace, request["sizes"]),
        }

    def _do_missing(self, request: dict[str, Any]) -> dict[str, Any]:
        """Which files have to be sent, by their hash."""
        if request["force"]:
            self._workspace.clear_incoming()
        known = releases.missing(self._workspace, request["sizes"])
        return {"missing": [*request["sizes"]] if request["force"] else known}

    def _do_wheels(self, request: dict[str, Any]) -> dict[str, Any]:
        folder = self._workspace.wheels
        return {"missing": [name for name in request["names"] if not _is_file(folder, name)]}

    def _do_content(self, request: dict[str, Any]) -> None:
        """A file follows: one of a release, or a wheel."""
        name = os.path.basename(request.get("wheel", "")) or request["hash"]
        folder = self._workspace.wheels if "wheel" in request else self._workspace.incoming
        blocks = wire.receive_content(self._requests)
        with disk_errors(self._workspace):
            target = os.path.join(folder, name)
            self._workspace.receive(target, request["hash"], blocks, request["path"])

    def _do_sent(self, request: dict[str, Any]) -> dict[str, Any]:
        """All contents were sent, and are not answered one by one."""
        return {}

    def _do_environment(self, request: dict[str, Any]) -> dict[str, Any]:
        """The name of the environment for a key; empty if it has to be made, and may not be."""
        key, force = request["key"], request["force"]
        found = None if force else environment.complete(self._workspace, key)
        if found is not None or request["only_look"]:
            return {"name": found or ""}
        if request["wheels"] is None:
            self._say("makes the environment with pip, which may take minutes")
        made = environment.make(self._workspace, key, request["requirements"], request["wheels"])
        self._workspace.keep_wheels(request["wheels"] or ())
        return {"name": made}

    def _do_release(self, request: dict[str, Any]) -> dict[str, Any]:
        """Make the release, and use it from now on."""
        entries, venv = request["entries"], request["venv"]
        name = releases.make(self._workspace, request["id"], entries, venv)
        releases.switch(self._workspace, name)
        self._workspace.clear_incoming()
        return {"name": name, "removed": releases.prune(self._workspace)}

    def _do_rollback(self, request: dict[str, Any]) -> dict[str, Any]:
        if request["dry_run"]:
            name = self._workspace.current_release()
            before = None if name is None else releases.previous(self._workspace, name)
            if name is None or before is None:
                raise Refusal("there is no release to go back to")
            return {"from": name, "to": before}
        name, before = releases.roll_back(self._workspace)
        return {"from": name, "to": before}


def _is_file(folder: str, name: str) -> bool:
    return os.path.isfile(os.path.join(folder, os.path.basename(name)))


class Requests:
    """Standard input. Once `limited`, the process ends if nothing comes for a minute."""

    def __init__(self, file: BufferedReader) -> None:
        self._file = file
        self.limited = False

    def read(self, size: int) -> bytes:
        parts = []
        while size:
            signal.alarm(_SILENCE_S if self.limited else 0)
            part = self._file.read1(min(size, wire.BLOCK_BYTES))
            if not part:
                break
            parts.append(part)
            size -= len(part)
        signal.alarm(0)
        return b"".join(parts)


def main() -> None:
    for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGALRM, signal.SIGCHLD):
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what programs print is no answer
    answers.write(wire.READY)
    answers.flush()
    try:
        SyncService(Requests(sys.stdin.buffer), answers).run()  # type: ignore[arg-type]
    except (wire.Closed, BrokenPipeError):
        sys.exit(1)


def facts(workspace: HostStore) -> dict[str, Any]:
    current = workspace.current_release()
    return {
        "root": workspace.root,
        "python": sys.executable,
        "word": sys.argv[1],
        "version": list(sys.version_info[:3]),
        "is_environment": _is_environment(),
        "has_venv": _has_venv(),
        "machine": platform.machine(),
        "libc": _libc(),
        "markers": _markers(),
        "current": current,
        "id": releases.identity(workspace, current),
        "free": workspace.free_bytes(),
    }


def _is_environment() -> bool:
    above = os.path.dirname(os.path.dirname(sys.executable))
    return os.path.isfile(os.path.join(above, "pyvenv.cfg"))


def _has_venv() -> bool:
    import importlib.util

    return importlib.util.find_spec("venv") is not None


def _libc() -> list[Any]:
    """`["glibc", "2.36"]`; empty for another library."""
    try:
        text = os.confstr("CS_GNU_LIBC_VERSION") or ""
    except (ValueError, OSError):
        return []
    return text.split()[:2]


def _markers() -> dict[str, str]:
    """The variables of environment markers (PEP 508)."""
    return {
        "implementation_name": sys.implementation.name,
        "implementation_version": platform.python_version(),
        "os_name": os.name,
        "platform_machine": platform.machine(),
        "platform_python_implementation": platform.python_implementation(),
        "platform_release": platform.release(),
        "platform_system": platform.system(),
        "platform_version": platform.version(),
        "python_full_version": platform.python_version(),
        "python_version": ".".join(platform.python_version_tuple()[:2]),
        "sys_platform": sys.platform,
    }
