"""What is watched, and what the changes of files mean for processes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.model.record import Record
from launcher.run.watch import file_checks
from launcher.run.watch.file_checks import State, digest_of, state_of
from launcher.run.watch.watched_programs import WatchedProgram, files_of, forget_imports, resolved

LAUNCH = ""  # in place of the name of a process: the launch file
UNKNOWN = "unknown"  # in place of a digest: not what is in the file now


class _Entry:
    """A process, or the launch file: its files, and the digest of what it has loaded of each.

    `wanted` are the others that it would load if it was started now.
    """

    def __init__(self, program: WatchedProgram | None, started_ns: int) -> None:
        self.program = program
        self.started_ns = started_ns
        self.loaded: dict[str, str | None] = {}
        self.wanted: list[str] = []

    @property
    def paths(self) -> list[str]:
        return [*self.loaded, *self.wanted]


class Changed(Record):
    """These files have changed, and can be loaded: process -> when the last of its files did."""

    paths: tuple[str, ...]
    processes: tuple[tuple[str, int], ...]
    launch: bool = False


class Broken(Record):
    """A file that these processes have loaded cannot be loaded any more."""

    error: LauncherError
    processes: tuple[str, ...]


class Deleted(Record):
    """A file that these processes have loaded does not exist any more."""

    path: str
    processes: tuple[str, ...]


Report = Changed | Broken | Deleted


class Watched:
    """`find_files` returns the files that a program loads; tests replace it."""

    def __init__(self, find_files: Callable[[WatchedProgram], list[str]] = files_of) -> None:
        self._find_files = find_files
        self._entries: dict[str, _Entry] = {}
        self._states: dict[str, State] = {}
        self._digests: dict[str, str | None] = {}
        self._reported: dict[str, str | None] = {}  # digest of the content that had a problem
        self._problems: dict[str, tuple[LauncherError | None, list[str]]] = {}

    # ---- what is watched

    @property
    def paths(self) -> list[str]:
        return list(self._states)

    def files(self, name: str) -> list[str]:
        return list(self._entries[name].loaded)

    def add_process(self, name: str, program: WatchedProgram, started_ns: int) -> list[str]:
        """It was started; the files that have changed since."""
        before = self._entries.get(name)
        if before is not None:
            forget_imports()  # modules may have come since the change that has restarted it
        program = resolved(program, before.program if before else None)
        return self._add(name, _Entry(program, started_ns), self._find_files(program))

    def add_launch(self, paths: Sequence[str], started_ns: int) -> list[str]:
        """The launch file was evaluated, which has read these."""
        return self._add(LAUNCH, _Entry(None, started_ns), paths)

    def forget(self, name: str) -> None:
        self._entries.pop(name, None)
        self._drop_unused()

    def _add(self, name: str, entry: _Entry, paths: Iterable[str]) -> list[str]:
        before = self._entries[name].loaded if name in self._entries else {}
        self._entries[name] = entry
        changed = [path for path in paths if not self._note_loaded(entry, path, before)]
        self._drop_unused()
        return changed

    def _note_loaded(self, entry: _Entry, path: str, before: Mapping[str, str | None]) -> bool:
        """Whether all have loaded what is in the file now, as far as can be known.

        `before` is what this one had loaded in its last life, or was to load.
        """
        state, digest = state_of(path), digest_of(path)
        is_current = before.get(path) == digest or state.changed_ns <= entry.started_ns
        is_as_known = self._states.get(path, state).stamp == state.stamp
        self._states[path], self._digests[path] = state, digest
        entry.loaded[path] = digest if is_current else UNKNOWN
        return is_current and is_as_known

    def _drop_unused(self) -> None:
        used = {path for entry in self._entries.values() for path in entry.paths}
        for path in self._states.keys() - used:
            del self._states[path], self._digests[path]
            self._reported.pop(path, None)

    # ---- changes

    def look(self) -> dict[str, int]:
        """The files that are not as they were when they were looked at last, and when they changed.

        The time is 0 for those that are deleted.
        """
        changed = {}
        for path, before in self._states.items():
            state = state_of(path)
            if before.stamp != state.stamp:
                changed[path] = state.changed_ns
                self._states[path] = state
        return changed

    def settled(self, paths: Iterable[str], busy: Iterable[str] = ()) -> list[Report]:
        """The reports when these changes are over; `busy` are files that still change."""
        paths = list(paths)
        if not paths:
            return []
        forget_imports()
        for path in paths:
            if path in self._states:
                self._digests[path] = digest_of(path)
                if self._reported.get(path) != self._digests[path]:
                    self._reported.pop(path, None)
        self._problems.clear()
        busy, ready = set(busy), []
        for name, entry in self._entries.items():
            changed = self._changed(entry)
            if not changed:
                entry.wanted = []  # what held the restart was withdrawn
            elif busy.isdisjoint(entry.paths) and self._can_load(name, entry):
                ready.append((name, [path for path in changed if path in entry.paths]))
                entry.loaded.update({path: self._digests[path] for path in entry.paths})
                entry.wanted = []
        self._drop_unused()
        return [*self._new_problems(), *([self._as_changed(ready)] if ready else [])]

    def _changed(self, entry: _Entry) -> list[str]:
        """What it has loaded and has changed, and what it would load since then."""
        changed = self._outdated(entry)
        return [*changed, *entry.wanted] if changed else []

    def _outdated(self, entry: _Entry) -> list[str]:
        return [path for path, digest in entry.loaded.items() if digest != self._digests[path]]

    def _can_load(self, name: str, entry: _Entry) -> bool:
        """Whether it can be started with its files as they are now, which are watched from now."""
        if entry.program is None:
            return True  # its evaluation reports what is wrong
        files = self._find_files(entry.program)
        for path in files:
            if path not in self._states:
                self._states[path], self._digests[path] = state_of(path), digest_of(path)
        entry.wanted = [path for path in files if path not in entry.loaded]
        needed = [*files[:1], *entry.program.parameter_files]
        missing = [path for path in needed if self._digests.get(path) is None]
        outdated = self._outdated(entry)
        if all(self._digests[path] is None for path in outdated):
            missing += outdated  # nothing has taken the place of what was deleted
        for path in dict.fromkeys(missing):
            self._problem(path, None, name)
        is_whole = True
        for path in files:
            if self._digests[path] is not None and entry.loaded.get(path) != self._digests[path]:
                is_whole = self._check(name, path, entry.program) and is_whole
        return is_whole and not missing

    def _check(self, name: str, path: str, program: WatchedProgram) -> bool:
        error = file_checks.error_in(path, is_parameters=path in program.parameter_files)
        if error is not None:
            self._problem(path, error, name)
            return False
        file_checks.forget_byte_code(path)
        return True

    # ---- what is reported

    def _problem(self, path: str, error: LauncherError | None, name: str) -> None:
        self._problems.setdefault(path, (error, []))[1].append(name)

    def _new_problems(self) -> Iterator[Report]:
        """Each once for one content of the file."""
        for path, (error, names) in self._problems.items():
            if self._reported.get(path, UNKNOWN) == self._digests.get(path):
                continue
            self._reported[path] = self._digests.get(path)
            yield Deleted(path, tuple(names)) if error is None else Broken(error, tuple(names))

    def _as_changed(self, ready: Sequence[tuple[str, Sequence[str]]]) -> Changed:
        def newest(paths: Iterable[str]) -> int:
            return max(self._states[path].changed_ns for path in paths)

        return Changed(
            paths=tuple(dict.fromkeys(path for _, changed in ready for path in changed)),
            processes=tuple((name, newest(changed)) for name, changed in ready if name != LAUNCH),
            launch=any(name == LAUNCH for name, _ in ready),
        )
