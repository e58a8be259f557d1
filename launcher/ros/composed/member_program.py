"""Runs the program of a member as `__main__`: a script, a console script, or `python -m`."""

from __future__ import annotations

import os
import runpy
import sys
import types
from typing import TYPE_CHECKING, Any

from launcher.packages.python_program import program_of
from launcher.ros.composed import current

if TYPE_CHECKING:
    from launcher.ros.composed.member import Member


def run_program(one: Member) -> None:
    """In the thread of the member; whatever the program raises passes."""
    program = program_of(one.command, os.environ)
    if isinstance(program, str):
        raise SystemExit(f"{one.name} is no Python program: {program}")
    if program.module:
        one.argv = ["-m", *program.words]
        search_first("")
        spec = runpy._get_module_details(program.module)[1]  # type: ignore[attr-defined]
        one.argv[0] = str(spec.origin)
        # Without a place in sys.modules, which has one `__main__` for all.
        runpy.run_module(program.module, run_name="__main__", alter_sys=False)
        return
    one.argv = [program.script, *program.words]
    path = os.path.abspath(program.script)
    search_first(os.path.dirname(os.path.realpath(path)))
    with open(path, "rb") as file:
        code = compile(file.read(), program.script, "exec", dont_inherit=True)
    variables: dict[str, Any] = {
        "__name__": "__main__",
        "__file__": program.script,
        "__builtins__": __builtins__,
        "__cached__": None,
        "__doc__": None,
        "__loader__": None,
        "__package__": None,
        "__spec__": None,
    }
    exec(code, variables)


def search_first(folder: str) -> None:
    """Look for modules in this folder, too: the members share `sys.path`."""
    if folder not in sys.path:
        sys.path.insert(0, folder)


class MemberSys(types.ModuleType):
    """The module `sys` as each member sees it: with its own `argv`."""

    @property
    def argv(self) -> list[str]:
        one = current.member()
        found: list[str] = self.__dict__["argv"] if one is None else one.argv
        return found

    @argv.setter
    def argv(self, words: list[str]) -> None:
        one = current.member()
        if one is None:
            self.__dict__["argv"] = words
        else:
            one.argv = words


def install() -> None:
    sys.__class__ = MemberSys
