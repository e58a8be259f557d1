"""`bag check`: whether a bag is whole, and its repair."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, JSON, option
from launcher.base.text import count
from launcher.packages.distribution import installed
from launcher.ros.verb import show, warn

if TYPE_CHECKING:
    from launcher.bag.check import BagReport


def _check(options: Parsed) -> int:
    from launcher.bag import check
    from launcher.posix.allocator import keep_freed_memory

    keep_freed_memory()
    reports = [check.check(path) for path in options.bags]
    if options.repair:
        for report in reports:
            if report.is_damaged:
                for line in check.repair(report, installed() or ""):
                    print(line)
        reports = [check.check(path) for path in options.bags]
    show(options, {"bags": [_document(one) for one in reports]}, _lines(reports))
    if all(report.is_whole for report in reports):
        return ExitCode.OK
    broken = " ".join(report.path for report in reports if report.is_repairable)
    if broken and not options.repair:
        from launcher.base.program import program

        warn(f"hint: {program()} bag check --repair {broken}")
    return ExitCode.PROCESS_FAILED


def _lines(reports: list[BagReport]) -> Iterator[str]:
    for report in reports:
        for file in report.files:
            counted = count(file.extent.total, "message")
            if file.is_whole:
                yield f"{file.name}: whole, {counted}"
            for note in (*file.notes, *file.conflicts):
                yield f"{file.name}: {note}"
            for fault in file.faults:
                yield f"{file.name}: {fault.text} (readable: {counted})"
        yield from report.problems


def _document(report: BagReport) -> dict[str, Any]:
    return {
        "path": report.path,
        "whole": report.is_whole,
        "problems": report.problems,
        "files": [
            {
                "name": file.name,
                "messages": file.extent.total,
                "notes": file.notes,
                "conflicts": file.conflicts,
                "faults": [
                    {"offset": fault.offset, "text": fault.text, "lost": fault.lost}
                    for fault in file.faults
                ],
            }
            for file in report.files
        ],
    }


COMMAND = Command(
    "bag check",
    "find out whether bags are whole, and repair them",
    about="Read every byte of bags. Exit code 1 if one is damaged or was not finished.",
    arguments=(option("BAG ...", "folders, or .mcap and .db3 files", name="bags"),),
    options=(
        option(
            "--repair",
            "finish files of recorders that were killed, leave out what is damaged (the damaged "
            "file is kept) and write metadata.yaml anew",
        ),
        JSON,
        DEBUG,
    ),
    abbreviations=True,
    run=_check,
)
