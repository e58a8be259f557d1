"""Makes a release from files that are there, switches to it, and removes old ones."""

from __future__ import annotations

import contextlib
import json
import os
import re
import subprocess

from launcher.hosts.sync.on_host.store import (
    FULL,
    RECORD,
    HostStore,
    Refusal,
    disk_errors,
    flush,
    remove_folder,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

KEEP = 3
_MARGIN_BYTES = 4 * 1024 * 1024
_PARTIAL = ".partial"


def identity(workspace: HostStore, name: str | None) -> str:
    """The id of a release; empty if it is not there, or not as it was brought."""
    if name is None or workspace.changed_files(name):
        return ""
    return str(workspace.record(name).get("id", ""))


def missing(workspace: HostStore, sizes: dict[str, int]) -> list[str]:
    """The hashes of which no file is here; Refusal if there is no space for them."""
    known = workspace.contents()
    wanted = [digest for digest in sizes if digest not in known]
    needed = sum(sizes[digest] for digest in wanted)
    free = workspace.free_bytes()
    if needed and needed + _MARGIN_BYTES > free:
        raise Refusal(
            f"{needed / 1e6:.1f} MB are needed there, and {free / 1e6:.1f} MB are free below "
            f"{workspace.root}",
            "make space there and repeat the command; the release in use was not changed",
        )
    return wanted


def make(workspace: HostStore, wanted: str, entries: list[list[Any]], venv: str) -> str:
    """A complete release of these entries, not yet in use; its name."""
    _remove_partial(workspace)
    name = f"{_next_number(workspace):06d}-{wanted[:8]}"
    final = os.path.join(workspace.releases, name)
    partial = final + _PARTIAL
    with disk_errors(workspace):
        try:
            os.makedirs(partial)
            files = _lay_out(workspace, partial, entries)
            _compile(partial, entries)
            record = {"id": wanted, "venv": venv, "files": files}
            with open(os.path.join(partial, RECORD), "w", encoding="ascii") as file:
                json.dump(record, file)
            flush(partial)
            os.rename(partial, final)
        except BaseException:
            remove_folder(partial)
            raise
    return name


def _lay_out(workspace: HostStore, folder: str, entries: list[list[Any]]) -> dict[str, list[Any]]:
    """Link the files to their places; path -> hash, size and time of each."""
    known = workspace.contents()
    files: dict[str, list[Any]] = {}
    used: set[tuple[str, bool]] = set()
    for kind, path, value, is_executable in entries:
        place = os.path.join(folder, _checked(path))
        os.makedirs(os.path.dirname(place), exist_ok=True)
        if kind == "link":
            os.symlink(value, place)
            continue
        _place(known[value], place, is_executable)
        used.add((value, is_executable))
        found = os.lstat(place)
        files[path] = [value, found.st_size, found.st_mtime_ns]
    return files


def _place(source: str, place: str, is_executable: bool) -> None:
    """Link a file; read-only, since releases share it. Copy it if its mode has to differ."""
    mode = 0o555 if is_executable else 0o444
    is_new = os.path.basename(os.path.dirname(source)) == "incoming"
    if is_new and os.lstat(source).st_nlink == 1:
        os.chmod(source, mode)
    if os.lstat(source).st_mode & 0o777 == mode:
        try:
            os.link(source, place)
            _link_compiled(source, place)
            return
        except OSError as error:
            if error.errno in FULL:
                raise
    import shutil

    shutil.copyfile(source, place)
    os.chmod(place, mode)


def _link_compiled(source: str, place: str) -> None:
    """What Python has compiled of an unchanged module is as good for its new place."""
    if not place.endswith(".py"):
        return
    before, name = os.path.split(source)
    cache = os.path.join(before, "__pycache__")
    with contextlib.suppress(OSError):
        for found in os.listdir(cache):
            if found.startswith(f"{name[:-3]}.cpython-"):
                target = os.path.join(os.path.dirname(place), "__pycache__")
                os.makedirs(target, exist_ok=True)
                os.link(os.path.join(cache, found), os.path.join(target, found))


def _compile(folder: str, entries: list[list[Any]]) -> None:
    """Have Python compile modules now instead of at their first import."""
    python = os.path.join(folder, "bin/python")
    if not os.path.exists(python) or not any(path.endswith(".py") for _, path, *_ in entries):
        return
    code = "import compileall,sys;[compileall.compile_dir(d,quiet=2) for d in sys.argv[1:]]"
    below = [os.path.join(folder, name) for name in ("lib", "install")]
    with contextlib.suppress(OSError):
        subprocess.run(
            [python, "-I", "-S", "-c", code, *below],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            check=False,
        )


def _checked(path: str) -> str:
    if os.path.isabs(path) or ".." in path.split("/") or not path:
        raise Refusal(f"'{path}' leads out of the release")
    return path


def _next_number(workspace: HostStore) -> int:
    numbers = [int(name[:6]) for name in os.listdir(workspace.releases) if name[:6].isdigit()]
    return max(numbers, default=0) + 1


def _remove_partial(workspace: HostStore) -> None:
    for name in os.listdir(workspace.releases):
        if name.endswith(_PARTIAL):
            remove_folder(os.path.join(workspace.releases, name))


# ---- the release in use


def switch(workspace: HostStore, name: str) -> None:
    """Use a release from now on, and note which one was used before."""
    before = workspace.current_release()
    with disk_errors(workspace):
        if before is not None and before != name:
            workspace.point(_before(workspace, name), before)
        workspace.point(workspace.current, os.path.join("releases", name))


def roll_back(workspace: HostStore) -> tuple[str, str]:
    """Use the release that was used before; the names of both. Refusal if there is none."""
    name = workspace.current_release()
    if name is None:
        raise Refusal("nothing was brought there yet", "leave out --rollback")
    before = previous(workspace, name)
    if before is None:
        raise Refusal(f"there is no release before {name}")
    with disk_errors(workspace):
        workspace.point(workspace.current, os.path.join("releases", before))
    return name, before


def previous(workspace: HostStore, name: str) -> str | None:
    """The release that was used before this one."""
    try:
        before = os.path.basename(os.readlink(_before(workspace, name)))
    except OSError:
        return None
    return before if before in workspace.names() else None


def _before(workspace: HostStore, name: str) -> str:
    return os.path.join(workspace.releases, f".before-{name}")


# ---- old releases


def prune(workspace: HostStore) -> list[str]:
    """Remove releases and environments that are old and that no process uses; their names."""
    current = workspace.current_release()
    keep = [] if current is None else _line(workspace, current)
    newest = list(reversed(workspace.names()))
    kept = {*keep[:KEEP], *newest[: max(0, KEEP - len(keep[:KEEP]))], *newest[:1]}
    running = _used_now(workspace)
    removed = []
    for name in newest:
        if name not in kept and name not in running:
            remove_folder(os.path.join(workspace.releases, name))
            with contextlib.suppress(OSError):
                os.unlink(_before(workspace, name))
            removed.append(name)
    _prune_venvs(workspace, running)
    return removed


def _line(workspace: HostStore, name: str) -> list[str]:
    """The release and those before it, in the order of rolling back."""
    line = [name]
    while (found := previous(workspace, line[-1])) is not None and found not in line:
        line.append(found)
    return line


def _prune_venvs(workspace: HostStore, running: set[str]) -> None:
    needed = {str(workspace.record(name).get("venv", "")) for name in workspace.names()}
    for key in os.listdir(workspace.venvs):
        if key not in needed and key not in running:
            remove_folder(os.path.join(workspace.venvs, key))


def _used_now(workspace: HostStore) -> set[str]:
    """The releases and environments that running processes of this user have in their paths."""
    pattern = re.escape(os.fsencode(os.path.realpath(workspace.root)))
    place = re.compile(pattern + rb"/(?:releases|venvs)/([^/:\0]+)")
    found: set[str] = set()
    for pid in filter(str.isdigit, os.listdir("/proc")):
        # If its main thread has ended before others, only they show what it uses.
        shown = next(filter(None, map(_paths_of, (pid, *_threads(pid)))), b"")
        found.update(os.fsdecode(name) for name in place.findall(shown))
    return found


def _paths_of(number: str) -> bytes:
    """What /proc shows of the paths that a process or thread uses; empty if it has ended."""
    shown = b""
    for file in ("environ", "cmdline", "maps"):
        with contextlib.suppress(OSError), open(f"/proc/{number}/{file}", "rb") as opened:
            shown += opened.read()
    return shown


def _threads(pid: str) -> list[str]:
    try:
        return os.listdir(f"/proc/{pid}/task")
    except OSError:
        return []
