"""Orders on a host: the words, the environment and the files of a process there."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, MutableMapping

from launcher.base.model.record import Record
from launcher.hosts.file.order import Order
from launcher.hosts.file.references import (
    ExecutableReference,
    Inherited,
    InterpreterReference,
    Part,
    SentFile,
    SharedFile,
    Word,
)
from launcher.packages.finder import find_executable, share_directory

_PRIVATE = 0o700


class Resolved(Record):
    """What is executed, as `subprocess.Popen` takes it."""

    argv: tuple[str, ...]
    env: Mapping[str, str]
    cwd: str | None

    def __repr__(self) -> str:
        """Without the environment, which may have secrets."""
        return f"Resolved({self.argv!r}, cwd={self.cwd!r})"


def resolve(order: Order, folder: str, environ: Mapping[str, str]) -> Resolved:
    """What the order means on this machine; its files are written to `folder`.

    `environ` is the environment that the process inherits. LauncherError if a package or an
    executable is not found here; OSError if a file cannot be written.
    """
    resolver = _Resolver(folder, environ)
    argv = tuple(map(resolver.word, order.words))
    cwd = order.cwd if order.cwd_in_share is None else resolver.part(order.cwd_in_share)
    env = environment_with_scripts(environ)
    variables = {name: resolver.word(word) for name, word in order.variables.items()}
    for name in order.unset:
        env.pop(name, None)
    _write_files(order, folder, {m: resolver.part(s) for m, s in order.marks.items()})
    return Resolved(argv=argv, env={**env, **order.environment, **variables}, cwd=cwd)


def environment_with_scripts(environ: Mapping[str, str]) -> MutableMapping[str, str]:
    """The environment, with the programs of this Python's virtual environment in `PATH`."""
    if sys.prefix == sys.base_prefix:
        return dict(environ)
    folder = os.path.join(sys.prefix, "bin")
    entries = [entry for entry in environ.get("PATH", os.defpath).split(":") if entry != folder]
    return {**environ, "PATH": ":".join([folder, *entries])}


class _Resolver:
    def __init__(self, folder: str, environ: Mapping[str, str]) -> None:
        self._folder = folder
        self._environ = environ

    def word(self, word: Word) -> str:
        return "".join(map(self.part, word))

    def part(self, part: Part) -> str:
        match part:
            case str():
                return part
            case ExecutableReference():
                return str(find_executable(part.package, part.name, self._environ))
            case SharedFile():
                share = str(share_directory(part.package, self._environ))
                return os.path.join(share, part.path) if part.path else share
            case SentFile():
                return os.path.join(self._folder, part.name)
            case InterpreterReference():
                return sys.executable
            case Inherited():
                return self._environ.get(part.variable, "")


def _write_files(order: Order, folder: str, paths: Mapping[str, str]) -> None:
    if order.files:
        os.makedirs(folder, _PRIVATE, exist_ok=True)
    for name, content in order.files.items():
        for mark, path in paths.items():
            content = content.replace(mark.encode(), os.fsencode(path))
        path = os.path.join(folder, os.path.basename(name))
        fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
        with open(fd, "wb") as file:
            file.write(content)
