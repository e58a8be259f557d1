"""The output of one package's tools, and where the files are that it names."""

from __future__ import annotations

import os
from dataclasses import dataclass

from launcher.base.errors import LauncherError
from launcher.workspace.building.sources.source_text import PackageText, SourceError, shown


@dataclass(frozen=True)
class BuildOutput:
    """`folder` has the sources of the package, `build` is its build folder."""

    package: str
    folder: str
    build: str
    text: str

    def has(self, *signs: str) -> bool:
        return any(sign in self.text for sign in signs)

    def own(self, path: str) -> str | None:
        """The file of the package's sources that a tool means; None for files of others.

        Tools name files relative to the sources or to the build folder, which has links to them.
        """
        for resolve in (os.path.abspath, os.path.realpath):  # tools may resolve links
            folder, build = resolve(self.folder), resolve(self.build)
            full = resolve(os.path.join(self.folder, path))
            if full.startswith(build + os.sep):
                full = os.path.join(folder, os.path.relpath(full, build))
            if full.startswith(folder + os.sep) and os.path.isfile(full):
                return os.path.join(self.folder, os.path.relpath(full, folder))
        return None

    def error(
        self,
        message: str,
        path: str,
        line: int | None = None,
        column: int | None = None,
        *,
        at: str | None = None,
        hint: str | None = None,
    ) -> LauncherError:
        """An error with a place in a file, and the line if the file can be read."""
        try:
            return PackageText(path, errors="replace").error(
                message, line, column, at=at, hint=hint
            )
        except SourceError:
            where = f"{shown(path)}:{line}" if line else shown(path)
            return LauncherError(message, where=where, hint=hint)
