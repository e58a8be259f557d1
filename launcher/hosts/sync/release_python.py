"""The program `bin/python` of a release, which every engine of a host starts."""

from __future__ import annotations

import posixpath
import shlex

from launcher.hosts.ssh import MADE_WITH
from launcher.hosts.sync.release_tree import TreeEntry

PATH = "bin/python"

_TEXT = """\
#!/bin/sh
# Python with the launcher and the packages of this release. Made by `launcher hosts sync`.
case $0 in */*) here=${{0%/*}} ;; *) here=. ;; esac
release=$(CDPATH= cd -- "$here/.." && pwd -P) || exit
case ":$PYTHONPATH:" in
  *":$release/lib:"*) ;;
  *) export PYTHONPATH="$release/lib${{PYTHONPATH:+:$PYTHONPATH}}" ;;
esac
export LAUNCHER_WORKSPACE="$release"
{start} "$@"
"""
_OF_VENV = """\
venv=${{release%/releases/*}}/venvs/{name}
export PATH="$venv/bin:$PATH"
exec "$venv/bin/python\""""


def of_environment(name: str) -> TreeEntry:
    """That of an environment in `venvs/`."""
    return _entry(_OF_VENV.format(name=shlex.quote(name)))


def of_host(word: str, executable: str) -> TreeEntry:
    """That of the host, named `word`; a name without a folder is found after `setup` there."""
    return _entry(f"exec {shlex.quote(executable if '/' in word else word)}")


def made_with(word: str, named: str) -> TreeEntry:
    """Notes the interpreter of the host, and that of the hosts file, for `ssh.set_python`."""
    content = f"{word}\n{named}\n".encode("utf-8", "surrogateescape")
    return TreeEntry(path=posixpath.join(posixpath.dirname(PATH), MADE_WITH), content=content)


def _entry(start: str) -> TreeEntry:
    return TreeEntry(path=PATH, content=_TEXT.format(start=start).encode(), is_executable=True)
