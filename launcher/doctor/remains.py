"""What stays on this machine after the launcher was used: `doctor --uninstall-list`.

Each function of `_OWNERS` asks the owner of a folder where that is. Nothing is changed.
"""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from launcher.base import text_file
from launcher.base.model.record import Record
from launcher.base.program import program
from launcher.base.text import count
from launcher.doctor.checks import FIX, MB
from launcher.hosts.engine.systemd import unit_installer
from launcher.hosts.file.hosts_model import Host
from launcher.output.logs.old_runs import EVIDENCE, runs
from launcher.output.logs.run_directory import EVENTS, log_root
from launcher.posix import log_folder, socket_directory
from launcher.posix.cleanup.run_id import abandoned_groups
from launcher.posix.state_folder import state_folder
from launcher.run.monitor import shared_memory
from launcher.workspace.building.toolchain.compiler import zig_caches

# Names in the temporary directory. Most are gone with the process that has made them, unless that
# was killed; the eight letters are those of `tempfile`.
TEMPORARY = re.compile(
    r"launcher-(packages|plan|export|agent)-.*|(launcher-|launch_params_|smoke-)[a-z0-9_]{8}(\.\w+)?"
)
# Where the script of `completion` may have been put, by `completion --help` or by a custom.
_SHELL_FILES = (
    "~/.bashrc",
    "~/.bash_profile",
    "~/.zshrc",
    "~/.config/fish/config.fish",
    "~/.config/fish/completions/launcher.fish",
    "~/.local/share/bash-completion/completions/launcher",
)
_LOADS_COMPLETION = "launcher completion "
_IS_COMPLETION = "_launcher_completion"


class Remain(Record):
    """A file or folder, or what matches a pattern; `command` removes it."""

    what: str
    path: str
    size_bytes: int
    command: str


Environment = Mapping[str, str]
Found = Iterator[Remain]


def remains(env: Environment) -> list[Remain]:
    """All that is there, with `env` as the environment of the launcher that has left it."""
    found: list[Remain] = []
    for owner in _OWNERS:
        with contextlib.suppress(OSError):  # it is not there, or not ours to read
            found += owner(env)
    return found


def _runs(env: Environment) -> Found:
    root = log_root(env)
    names = runs(root)
    if names:
        find = f"find {shlex.quote(root)} -mindepth 2 -maxdepth 2 -name {EVENTS}"
        size = sum(size_of(f"{root}/{name}") for name in names)
        command = f"{find} -printf '%h\\0' | xargs -0 rm -r"
        yield Remain(f"logs of {count(len(names), 'run')}", root, size, command)
    latest = f"{root}/latest"
    if os.path.islink(latest) and os.path.basename(os.readlink(latest)) in names:
        yield _entry("link to the last run", latest)
    if os.path.isdir(f"{root}/{EVIDENCE}"):
        yield _entry("evidence of smoke tests that have failed", f"{root}/{EVIDENCE}")


def _node_logs(env: Environment) -> Found:
    """Each process with a node has a file, those of verbs and of other ROS programs as well."""
    root = log_root(env)
    logs = [entry for entry in os.scandir(root) if entry.name.endswith(".log")]
    if logs:
        what = f"logs of {count(len(logs), 'process')} outside of runs, other ROS programs included"
        command = f"find {shlex.quote(root)} -maxdepth 1 -name '*.log' -delete"
        yield Remain(what, f"{root}/*.log", sum(size_of(one.path) for one in logs), command)


def _private(env: Environment) -> Found:
    places = (*socket_directory.candidates(env, os.getuid()), *log_folder.places(env))
    for path in dict.fromkeys(map(str, places)):
        if os.path.lexists(path):
            yield _entry("sockets of runs, and logs that ~/.ros did not take", path)


def _state(env: Environment) -> Found:
    folder = state_folder(env)
    if os.path.isdir(folder):
        yield _entry("lines typed in the console, and which notices were shown", folder)


def _temporary(_: Environment) -> Found:
    for entry in sorted(os.scandir(tempfile.gettempdir()), key=lambda entry: entry.name):
        is_ours = entry.stat(follow_symlinks=False).st_uid == os.getuid()
        if is_ours and TEMPORARY.fullmatch(entry.name):
            yield _entry("temporary files", entry.path)


def _compiler_caches(env: Environment) -> Found:
    folder, prefix = os.path.split(zig_caches(env))
    for name in sorted(os.listdir(folder)):
        if name.startswith(prefix):
            yield _entry("what the compiler ziglang has built for `build`", f"{folder}/{name}")


def _synced(env: Environment) -> Found:
    folder = os.path.join(_home(env), Host.workspace)
    if os.path.isdir(folder):
        yield _entry("what `hosts sync` has brought here", folder)


def _units(env: Environment) -> Found:
    for home, systemctl in ((_home(env), "systemctl --user"), (None, "systemctl")):
        units, folders = unit_installer.places(home)
        with contextlib.suppress(OSError):
            for name in sorted(os.listdir(folders)):
                folder = f"{folders}/{name}"
                names = text_file.read(f"{folder}/{unit_installer.LIST}").split()
                files = shlex.join([folder, *(f"{units}/{unit}" for unit in names)])
                sudo = "" if os.access(folders, os.W_OK) else "sudo "
                steps = (
                    f"{systemctl} disable --now {shlex.join(names)}",
                    f"rm -r {files}",
                    f"{systemctl} daemon-reload",
                )
                size = size_of(folder) + sum(size_of(f"{units}/{unit}") for unit in names)
                what = f"{count(len(names), 'unit')} of systemd, by --enable"
                yield Remain(what, folder, size, "; ".join(f"{sudo}{step}" for step in steps))


def _completion(env: Environment) -> Found:
    for name in _SHELL_FILES:
        path = name.replace("~", _home(env), 1)
        with contextlib.suppress(OSError, UnicodeError):
            text = text_file.read(path)
            if _IS_COMPLETION in text:
                yield _entry("script of `completion`", path)
            elif _LOADS_COMPLETION in text:
                line = f"sed -i '/{_LOADS_COMPLETION}/d' {shlex.quote(path)}"
                size = sum(len(one) + 1 for one in text.split("\n") if _LOADS_COMPLETION in one)
                yield Remain("line that loads the completion", path, size, line)


def _shared_memory(_: Environment) -> Found:
    found = shared_memory.stale()
    if found:
        size = sum(one.size_bytes for one in found)
        yield Remain("shared memory of killed nodes", shared_memory.FOLDER, size, FIX)


def _groups(_: Environment) -> Found:
    for _run, group in abandoned_groups():
        yield Remain("control group of a killed run", group.path, 0, FIX)


_OWNERS: Sequence[Callable[[Environment], Found]] = (
    _runs,
    _node_logs,
    _private,
    _state,
    _temporary,
    _compiler_caches,
    _synced,
    _units,
    _completion,
    _shared_memory,
    _groups,
)


def _home(env: Environment) -> str:
    return env.get("HOME") or os.path.expanduser("~")


def _entry(what: str, path: str) -> Remain:
    is_folder = os.path.isdir(path) and not os.path.islink(path)
    return Remain(what, path, size_of(path), f"rm {'-r ' * is_folder}{shlex.quote(path)}")


def size_of(path: str) -> int:
    """The bytes on disk of a file, or of a folder with what is in it; no links are followed."""
    inner = (f"{at}/{name}" for at, _, names in os.walk(path) for name in names)
    size = 0
    for one in (path, *inner):
        with contextlib.suppress(OSError):  # removed just now
            size += os.lstat(one).st_blocks * 512
    return size


_NOTE = """\
{size} in all; nothing was removed. First end all runs: `{program} runs` lists them.
Not listed: environments and workspaces (.venv, build/, install/, log/), files that a command line
has named, and other hosts: run this there, too."""


def as_text(found: Sequence[Remain]) -> str:
    """Two lines for each, and what is not listed."""
    lines = []
    for one in found:
        lines.append(f"{_shown(one.size_bytes)}  {one.path}: {one.what}")
        lines.append(f"{'':12}-> {one.command}")
    total = _shown(sum(one.size_bytes for one in found))
    return "\n".join([*lines, _NOTE.format(size=total, program=program())])


def _shown(size_bytes: int) -> str:
    return f"{size_bytes / MB:6.1f} MiB" if size_bytes >= MB else f"{size_bytes // 1024:6} KiB"


def as_document(found: Sequence[Remain]) -> dict[str, Any]:
    """The same for `--json`."""
    names = ("what", "path", "size_bytes", "command")
    entries = [{name: getattr(one, name) for name in names} for one in found]
    total = sum(one.size_bytes for one in found)
    return {"size_bytes": total, "remains": entries}
