"""Warnings of programs that cannot be executed, before a process is started."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator

from launcher.base.model.spec import ProcessSpec
from launcher.packages.program_fault import ProgramFault, fault_of

_HEAD_BYTES = 64 * 1024


def program_warnings(specs: Iterable[ProcessSpec]) -> list[str]:
    """A line for each program of this machine that cannot be executed now, with its place."""
    return list(dict.fromkeys(_warnings(specs)))


def is_of_rclpy(spec: ProcessSpec) -> bool:
    """Whether its program is a file that names rclpy in its first part."""
    try:
        with open(os.path.join(spec.cwd or "", spec.argv[0]), "rb") as file:
            return b"rclpy" in file.read(_HEAD_BYTES)
    except OSError:
        return False


def _warnings(specs: Iterable[ProcessSpec]) -> Iterator[str]:
    known: dict[tuple[str, str | None, str | None, str], ProgramFault | None] = {}
    for spec in specs:
        program = spec.argv[0]
        if spec.shell or " " in program:  # there is a warning of a command in one word
            continue
        beside = os.path.dirname(spec.place.rpartition(":")[0]) or None
        key = (program, spec.cwd, beside, spec.env.get("PATH", ""))
        if key not in known:
            known[key] = fault_of(program, spec.env, spec.cwd, beside)
        fault = known[key]
        if fault is not None:
            is_of_package = fault.hint is None and spec.ros is not None and "/" not in program
            hint = "; hint: give its package=, or a path" if is_of_package else ""
            yield f"{spec.place}: {fault}{hint}"
