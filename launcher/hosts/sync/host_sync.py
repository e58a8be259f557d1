"""One host is synchronized."""

from __future__ import annotations

import getpass
import hashlib
import os
import socket
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launcher.errors import LauncherError
from launcher.hosts.failures import HostError, Problem
from launcher.hosts.model import Host
from launcher.hosts.ssh import host_python
from launcher.hosts.sync import natives, release_python, requirements, wheels
from launcher.hosts.sync.natives import Native
from launcher.hosts.sync.requirements import PinnedList
from launcher.hosts.sync.sync_session import SyncSession, blocks_of
from launcher.hosts.sync.tree import Release
from launcher.model.record import Record


class Options(Record):
    """`requirements` None: no environment is made. `wheelhouse` None: pip downloads there."""

    requirements: PinnedList | None = None
    wheelhouse: str | None = None
    dry_run: bool = False
    force: bool = False


class Outcome(Record):
    """What became of one host; bytes are those that went over the network.

    `changes` are lines `+ PATH`, `~ PATH`, `- PATH` of a dry run.
    """

    host: str
    release: str
    files: int = 0
    sent_files: int = 0
    sent_bytes: int = 0
    seconds: float = 0.0
    environment_s: float | None = None
    is_changed: bool = False
    before: str | None = None
    removed: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()


class HostSync:
    """Brings a release to one host. LauncherError from `run` and `roll_back`."""

    def __init__(
        self,
        host: Host,
        session: SyncSession,
        options: Options,
        say: Callable[[str], None],
        begin: float,
    ) -> None:
        """`begin` is on the monotonic clock."""
        self._host = host
        self._session = session
        self._options = options
        self._say = say
        self._begin = begin
        self._facts: dict[str, Any] = {}
        self._sent_bytes = 0
        self._environment_s: float | None = None

    def run(self, release: Release, compiled: Sequence[Native]) -> Outcome:
        self._ask_facts()
        target = wheels.target_of(self._facts)
        try:
            natives.check(compiled, target)
            files = self._wheels(target)
        except LauncherError as error:
            raise self._named(error) from None
        venv = self._environment(only_look=True, files=files)
        whole = self._with_python(release, venv or self._key)
        force = self._options.force
        if whole.id == self._facts["id"] and (venv or not self._key) and not force:
            return self._unchanged(whole)
        if self._options.dry_run:
            return self._compared(whole)
        answer = self._ask("lock", who=_who(), say=True)
        if self._key:
            venv = self._environment(only_look=False, files=files)
            whole = self._with_python(release, venv)
        if whole.id == answer["id"] and not force:
            return self._unchanged(whole)
        sent = self._send(whole)
        done = self._ask("release", id=whole.id, entries=whole.rows, venv=venv)
        return self._outcome(
            done["name"], whole, sent, is_changed=True, removed=tuple(done["removed"])
        )

    def roll_back(self) -> Outcome:
        """Use the release that was used before."""
        self._ask_facts()
        if not self._options.dry_run:
            self._ask("lock", who=_who(), say=True)
        done = self._ask("rollback", dry_run=self._options.dry_run)
        return Outcome(
            host=self._host.name,
            release=done["to"],
            before=done["from"],
            seconds=time.monotonic() - self._begin,
            is_changed=True,
        )

    # ---- the environment

    @property
    def _key(self) -> str:
        """What environments have in common that can be shared; empty: none is made."""
        listed, facts = self._options.requirements, self._facts
        if listed is None or self._host.setup or facts["is_environment"]:
            return ""
        words = [listed.digest, facts["python"], *map(str, facts["version"]), *facts["libc"]]
        return hashlib.sha256("\n".join(words).encode()).hexdigest()[:12]

    def _wheels(self, target: wheels.Target) -> list[str] | None:
        """The wheels of the host; None if pip downloads there."""
        listed, folder = self._options.requirements, self._options.wheelhouse
        if not self._key or listed is None or folder is None:
            return None
        pins = requirements.pins(listed, target.markers)
        return wheels.chosen(folder, pins, target, self._say)

    def _environment(self, *, only_look: bool, files: Sequence[str] | None) -> str:
        """The name of the environment there; empty if there is none, or none is needed."""
        listed, key = self._options.requirements, self._key
        if not key or listed is None:
            return ""
        force = self._options.force and not only_look
        request: dict[str, Any] = {"key": key, "requirements": listed.text, "wheels": files}
        found = self._ask("environment", only_look=True, force=force, **request)["name"]
        if found or only_look:
            return str(found)
        begin = time.monotonic()
        if files is not None:
            self._send_wheels(files)
        made = self._ask("environment", only_look=False, force=force, say=True, **request)["name"]
        self._environment_s = time.monotonic() - begin
        return str(made)

    def _send_wheels(self, files: Sequence[str]) -> None:
        missing = self._ask("wheels", names=list(files))["missing"]
        for name in missing:
            path = os.path.join(self._options.wheelhouse or "", name)
            request = {"do": "content", "wheel": name, "hash": wheels.digest_of(path)}
            self._send_content({**request, "path": path}, path)
        self._say(f"{len(missing)} of {len(files)} wheels sent")
        self._say("makes the environment, which may take a minute")

    def _with_python(self, release: Release, venv: str) -> Release:
        word = self._facts["word"]
        program = (
            release_python.of_environment(venv)
            if self._key
            else release_python.of_host(word, self._facts["python"])
        )
        note = release_python.made_with(word, host_python(self._host))
        return release.with_entries([program, note])

    # ---- files

    def _send(self, release: Release) -> int:
        """Send what is missing there; the number of files."""
        answer = self._ask("missing", sizes=release.sizes, force=self._options.force)
        for digest in answer["missing"]:
            entry = release.by_hash[digest]
            request = {"do": "content", "hash": digest, "path": entry.source or entry.path}
            self._session.send_content(request, entry.blocks(), self._count)
        self._ask("sent")
        return len(answer["missing"])

    def _send_content(self, request: Mapping[str, Any], path: str) -> None:
        self._session.send_content(dict(request), blocks_of(path), self._count)

    def _count(self, size: int) -> None:
        self._sent_bytes += size

    # ---- answers

    def _ask_facts(self) -> None:
        self._facts = self._ask("facts", workspace=self._host.workspace)
        if self._facts["word"] != host_python(self._host):
            word, wanted = self._facts["word"], self._host.python
            self._say(f"there is no Python '{wanted}', so {word} is used")

    def _ask(self, what: str, *, say: bool = False, **request: Any) -> dict[str, Any]:
        quiet = lambda _: None  # noqa: E731
        return self._session.ask({"do": what, **request}, self._say if say else quiet)

    def _named(self, error: LauncherError) -> LauncherError:
        """The error with the name of the host."""
        return HostError(self._host, Problem.OTHER, error.message, hint=error.hint)

    def _compared(self, release: Release) -> Outcome:
        found = self._ask("compare", entries=release.rows, sizes=release.sizes)
        changes = [
            f"{sign} {path}"
            for sign, kind in (("+", "new"), ("~", "changed"), ("-", "gone"))
            for path in found[kind]
        ]
        self._sent_bytes = sum(release.sizes[digest] for digest in found["missing"])
        name = self._facts["current"] or ""
        return self._outcome(
            name, release, len(found["missing"]), is_changed=True, changes=tuple(changes)
        )

    def _unchanged(self, release: Release) -> Outcome:
        return self._outcome(self._facts["current"] or "", release, 0)

    def _outcome(self, name: str, release: Release, sent: int, **more: Any) -> Outcome:
        return Outcome(
            host=self._host.name,
            release=name,
            files=len(release.rows),
            sent_files=sent,
            sent_bytes=self._sent_bytes,
            seconds=time.monotonic() - self._begin,
            environment_s=self._environment_s,
            **more,
        )


def _who() -> str:
    try:
        return f"{getpass.getuser()} on {socket.gethostname()}"
    except (OSError, KeyError):
        return socket.gethostname()
