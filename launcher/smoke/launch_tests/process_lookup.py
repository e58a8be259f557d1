"""Finds the processes that a test names: by action, or by a part of the name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from launcher.language.actions.process import ExecuteLocal
from launcher.language.naming import public

NO_CMD_ARGS = object()  # as `cmd_args`: only a process without arguments
_UNKNOWN = "Unknown - Process not launched yet"


@public("launch_testing.util.proc_lookup")
class NoMatchingProcessException(Exception):
    """No process is recorded that fits."""


def resolveProcesses(
    info_obj: Any,
    *,
    process: Any = None,
    cmd_args: Any = None,
    strict_proc_matching: bool = True,
) -> list[Any]:
    """The actions of the recorded processes that fit; all of them without `process`.

    NoMatchingProcessException for none; an Exception for several where `strict_proc_matching`.
    """
    known = list(info_obj.processes())
    if process is None:
        if not known:
            raise NoMatchingProcessException("No data recorded for any process")
        return known
    if isinstance(process, ExecuteLocal):
        if process not in known:
            raise NoMatchingProcessException(f"No data recorded for proc {_described(process)}")
        return [process]
    if not isinstance(process, str):
        kind = type(process)
        raise TypeError(f"proc argument must be 'ExecuteProcess' or 'str' not {kind}")
    if isinstance(cmd_args, str):
        cmd_args = [cmd_args]
    found = [one for one in known if _fits(one.process_details, process, cmd_args)]
    if found and (len(found) == 1 or not strict_proc_matching):
        return found
    names = ", ".join(sorted(map(_described, known)))
    if not found:
        raise NoMatchingProcessException(
            f"Did not find any processes matching name '{process}' and args '{cmd_args}'. "
            f"Procs: {names}"
        )
    raise Exception(
        f"Found multiple processes matching name '{process}' and cmd_args '{cmd_args}'. "
        f"Procs: {names}"
    )


def _fits(details: dict[str, Any], name: str, cmd_args: Any) -> bool:
    arguments = details["cmd"][1:]
    if name not in details["name"]:
        return False
    if cmd_args is NO_CMD_ARGS:
        return not arguments
    return all(one in arguments for one in cmd_args or ())


def _described(process: Any) -> str:
    """Name and arguments of a process; before its start the command, if that is plain text."""
    details = process.process_details
    if details:
        return " ".join([details["name"], *details["cmd"][1:]])
    words = process.process_description.cmd
    return " ".join(map(_plain, words)) if all(map(_is_plain, words)) else _UNKNOWN


def _is_plain(substitutions: Iterable[Any]) -> bool:
    return all(hasattr(one, "text") for one in substitutions)


def _plain(substitutions: Iterable[Any]) -> str:
    return "".join(one.text for one in substitutions)
