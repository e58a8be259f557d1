"""One host is synchronized."""

from __future__ import annotations

import contextlib
import getpass
import hashlib
import os
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from launcher.base.errors import LauncherError
from launcher.base.model.record import Record
from launcher.hosts.failures import HostError, Problem
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import host_python
from launcher.hosts.sync import (
    natives,
    pinned_list,
    release_python,
    wheels,
)
from launcher.hosts.sync.natives import Native
from launcher.hosts.sync.pinned_list import Pin, PinnedList
from launcher.hosts.sync.release_tree import Release
from launcher.hosts.sync.sync_session import SyncSession, blocks_of


class SyncOptions(Record):
    """`requirements` None: no environment is made. `wheelhouse` None: pip downloads there."""

    requirements: PinnedList | None = None
    wheelhouse: str | None = None
    dry_run: bool = False
    force: bool = False


class EnvironmentPlan(Record):
    """How an environment would be made; `wheels` None: by pip there. `missing` are names."""

    wheels: int | None = None
    sent: int = 0
    sent_bytes: int = 0
    folder: str = ""
    missing: str = ""


class SyncOutcome(Record):
    """The result for one host; bytes are those that went over the network.

    Of a dry run, `changes` are lines `+ PATH`, `~ PATH`, `- PATH`, and `environment` describes the
    one that would be made.
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
    environment: EnvironmentPlan | None = None


class HostSync:
    """Brings a release to one host. LauncherError from `run` and `roll_back`."""

    def __init__(
        self,
        host: Host,
        session: SyncSession,
        options: SyncOptions,
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
        self._files: list[str] | None = None  # the wheels, once they were chosen

    def run(self, release: Release, compiled: Sequence[Native]) -> SyncOutcome:
        self._ask_facts()
        self._report_unused()
        with self._naming_the_host():
            natives.check(compiled, self._target)
        force = self._options.force
        venv = self._environment_there()
        is_needed = bool(self._key) and (force or not venv)
        whole = self._with_python(release, venv or self._key)
        if whole.id == self._facts["id"] and not is_needed and not force:
            return self._unchanged(whole)
        if self._options.dry_run:
            return self._compared(whole, self._environment_plan() if is_needed else None)
        if is_needed:
            self._wheels()  # reports what is missing before anything is sent
        answer = self._ask("lock", who=_who(), say=True)
        if self._key:
            venv = self._environment()
            whole = self._with_python(release, venv)
        if whole.id == answer["id"] and not force:
            return self._unchanged(whole)
        sent = self._send(whole)
        done = self._ask("release", id=whole.id, entries=whole.rows, venv=venv)
        return self._outcome(
            done["name"], whole, sent, is_changed=True, removed=tuple(done["removed"])
        )

    def roll_back(self) -> SyncOutcome:
        """Use the release that was used before."""
        self._ask_facts()
        if not self._options.dry_run:
            self._ask("lock", who=_who(), say=True)
        done = self._ask("rollback", dry_run=self._options.dry_run)
        return SyncOutcome(
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

    @property
    def _target(self) -> wheels.PythonTarget:
        return wheels.target_of(self._facts)

    def _pins(self) -> list[Pin]:
        listed = self._options.requirements
        return pinned_list.pins(listed, self._target.markers) if listed is not None else []

    def _report_unused(self) -> None:
        if self._options.wheelhouse is not None and not self._key:
            why = "it has `setup`" if self._host.setup else "its Python is that of an environment"
            self._say(f"{why}, so no environment is made, and --wheelhouse is not used")

    def _wheels(self) -> list[str] | None:
        """The wheels of the host; None if pip downloads there."""
        folder = self._options.wheelhouse
        if self._files is None and folder is not None:
            with self._naming_the_host():
                self._files = wheels.chosen(folder, self._pins(), self._target, self._say)
        return self._files

    def _environment_there(self) -> str:
        """The name of the environment there; empty if there is none, or none is needed."""
        return self._ask_environment(only_look=True, force=False) if self._key else ""

    def _environment(self) -> str:
        """The name of the environment there, which is made if it has to be."""
        force = self._options.force
        if not force and (found := self._environment_there()):
            return found
        begin = time.monotonic()
        files = self._wheels()
        if files is not None:
            self._send_wheels(files)
        made = self._ask_environment(only_look=False, force=force, files=files)
        self._environment_s = time.monotonic() - begin
        return made

    def _ask_environment(
        self, *, only_look: bool, force: bool, files: Sequence[str] | None = None
    ) -> str:
        listed = self._options.requirements
        request = {"key": self._key, "requirements": listed.text if listed else ""}
        how = {"only_look": only_look, "force": force, "wheels": files}
        return str(self._ask("environment", say=not only_look, **request, **how)["name"])

    def _environment_plan(self) -> EnvironmentPlan:
        """What `_environment` would do; nothing is downloaded."""
        folder = self._options.wheelhouse
        if folder is None:
            return EnvironmentPlan()
        with self._naming_the_host():
            found = wheels.present(folder, self._pins(), self._target)
        sent = self._ask("wheels", names=found.files)["missing"]
        return EnvironmentPlan(
            wheels=len(found.files) + len(found.missing),
            sent=len(sent) + len(found.missing),
            sent_bytes=sum(os.path.getsize(os.path.join(folder, name)) for name in sent),
            folder=folder,
            missing=pinned_list.names(found.missing) if found.missing else "",
        )

    def _send_wheels(self, files: Sequence[str]) -> None:
        missing = self._ask("wheels", names=list(files))["missing"]
        for name in missing:
            path = os.path.join(self._options.wheelhouse or "", name)
            digest = wheels.digest_of(path)
            request = {"do": "content", "wheel": name, "hash": digest, "path": path}
            self._session.send_content(request, blocks_of(path), self._count)
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

    def _count(self, size: int) -> None:
        self._sent_bytes += size

    # ---- answers

    def _ask_facts(self) -> None:
        self._facts = self._ask("facts", workspace=self._host.workspace)
        if self._facts["word"] != host_python(self._host):
            word, wanted = self._facts["word"], self._host.python
            self._say(f"there is no Python '{wanted}', so {word} is used")

    def _ask(self, what: str, *, say: bool = False, **request: object) -> dict[str, Any]:
        quiet = lambda _: None  # noqa: E731
        return self._session.ask({"do": what, **request}, self._say if say else quiet)

    @contextlib.contextmanager
    def _naming_the_host(self) -> Iterator[None]:
        """Errors get the name of the host."""
        try:
            yield
        except LauncherError as error:
            text = error.message if error.where is None else f"{error.where}: {error.message}"
            raise HostError(self._host, Problem.OTHER, text, hint=error.hint) from None

    def _compared(self, release: Release, environment: EnvironmentPlan | None) -> SyncOutcome:
        found = self._ask("compare", entries=release.rows, sizes=release.sizes)
        changes = [
            f"{sign} {path}"
            for sign, kind in (("+", "new"), ("~", "changed"), ("-", "gone"))
            for path in found[kind]
        ]
        missing = [*release.sizes] if self._options.force else found["missing"]
        self._sent_bytes = sum(release.sizes[digest] for digest in missing)
        more = {"changes": tuple(changes), "environment": environment}
        name = self._facts["current"] or ""
        return self._outcome(name, release, len(missing), is_changed=True, **more)

    def _unchanged(self, release: Release) -> SyncOutcome:
        return self._outcome(self._facts["current"] or "", release, 0)

    def _outcome(self, name: str, release: Release, sent: int, **more: Any) -> SyncOutcome:
        return SyncOutcome(
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
