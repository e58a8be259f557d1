"""The environment hooks that colcon and ament install with packages, from their `.dsv` files.

A `.dsv` file says as data what the script beside it does in a shell. `source` in front of a path
without its suffix means another such file. No script is run: one that has no `.dsv` beside it is
reported in `scripts`.
"""

from __future__ import annotations

import os

from launcher.base.errors import UsageError

_PREPEND = ("prepend-non-duplicate", "prepend-non-duplicate-if-exists")
_SET = ("set", "set-if-unset")


class WorkspaceError(UsageError):
    """What is installed in a workspace cannot be read."""


class Hooks:
    """What the packages of one or several prefixes do to the environment.

    `front` and `back` are the entries of lists of paths, by the name of the variable; `values` are
    other variables, with whether they replace one that is set.
    """

    def __init__(self) -> None:
        self.front: dict[str, list[str]] = {}
        self.back: dict[str, list[str]] = {}
        self.values: dict[str, tuple[str, bool]] = {}
        self.scripts: list[str] = []

    def prepend(self, name: str, path: str) -> None:
        """Put a path in front of those of the variable, unless it is among them."""
        if path not in self.front.setdefault(name, []) and path not in self.back.get(name, ()):
            self.front[name].insert(0, path)

    def read_package(self, prefix: str, package: str) -> None:
        """Read the hooks of an installed package; WorkspaceError."""
        if not self._read(prefix, f"{prefix}/share/{package}/package.dsv"):
            # ament without colcon may have installed only these.
            self._source(prefix, f"share/{package}/local_setup", {"sh"})

    def _read(self, prefix: str, file: str) -> bool:
        """Read one file; False if there is none."""
        text = read_text(file)
        if text is None:
            return False
        sourced: dict[str, set[str]] = {}  # path without suffix -> the suffixes
        for number, line in enumerate(text.splitlines(), start=1):
            kind, _, rest = line.strip().partition(";")
            if kind == "source" and rest:
                stem, suffix = os.path.splitext(rest)
                sourced.setdefault(stem, set()).add(suffix[1:])
            elif kind and kind[0] != "#":
                self._apply(prefix, kind, rest.split(";"), f"{file}:{number}")
        for stem, suffixes in sourced.items():
            self._source(prefix, stem, suffixes)
        return True

    def _source(self, prefix: str, stem: str, suffixes: set[str]) -> None:
        stem = os.path.join(prefix, stem)
        script = f"{stem}.sh"
        if not self._read(prefix, f"{stem}.dsv") and "sh" in suffixes and os.path.isfile(script):
            self.scripts.append(os.path.normpath(script))

    def _apply(self, prefix: str, kind: str, words: list[str], where: str) -> None:
        name, *given = words
        is_name = name.isascii() and name.isidentifier()
        if kind in _SET and is_name and given:
            value = ";".join(given)
            path = os.path.join(prefix, value) if value else prefix
            value = path if os.path.exists(path) else value
            if kind == "set" or name not in self.values:
                self.values[name] = (value, kind == "set")
        elif kind in (*_PREPEND, "append-non-duplicate") and is_name:
            for path in (os.path.join(prefix, word) if word else prefix for word in given):
                if kind.endswith("-if-exists") and not os.path.exists(path):
                    continue
                if kind in _PREPEND:
                    self.prepend(name, path)
                elif path not in self.front.get(name, ()):
                    paths = self.back.setdefault(name, [])
                    paths += [] if path in paths else [path]
        else:
            raise WorkspaceError(
                f"'{';'.join([kind, *words])}' is not an environment hook",
                where=where,
                hint="build the package again",
            )


def read_text(file: str) -> str | None:
    """The content; None if the file does not exist, WorkspaceError if it cannot be read."""
    try:
        with open(file, encoding="utf-8", errors="surrogateescape") as opened:
            return opened.read()
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise WorkspaceError(f"{file} cannot be read: {error.strerror}") from None
