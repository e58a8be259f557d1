"""Finds the imports of programs in a process of its own, while the preparing process imports."""

from __future__ import annotations

import os
import sys

from launcher.base import strict_json

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    Found = tuple[list[str], list[tuple[str, str]]]


class Scan:
    """Begins at once. `programs` have `script` or `module`, and `folder`, first in their path."""

    def __init__(self, programs: Sequence[Mapping[str, str]]) -> None:
        self._answer, ours = os.pipe()
        self._pid = os.fork()
        if self._pid == 0:
            try:
                os.write(ours, strict_json.packed(_found(programs)).encode())
            finally:
                os._exit(0)
        os.close(ours)

    def result(self) -> Found:
        """(modules that are imported, (module, name) of what is taken from them); once."""
        with open(self._answer, "rb") as answer:
            text = answer.read()
        os.waitpid(self._pid, 0)
        modules, attributes = strict_json.unpacked(text) if text else ([], [])
        return modules, [(module, name) for module, name in attributes]


def _found(programs: Sequence[Mapping[str, str]]) -> Found:
    from launcher.packages.imports import imports_of_all

    modules: dict[str, None] = {}
    attributes: dict[tuple[str, str], None] = {}
    for folder in dict.fromkeys(program["folder"] for program in programs):
        here = [(one["script"], one["module"]) for one in programs if one["folder"] == folder]
        found = imports_of_all(here, path=[folder, *sys.path] if folder else None)
        modules.update(found.installed)
        attributes.update(found.attributes)
    return list(modules), list(attributes)
