"""`incident`: one HTML file about an incident of a run that lives or is over."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Sequence
from typing import Any

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, UsageError
from launcher.base.option import DEBUG, JSON, option
from launcher.base.program import browse
from launcher.base.text import aligned, escape
from launcher.base.verb_table import VERBS
from launcher.posix.json_output import print_document

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.faults.incident.document import IncidentDocument
    from launcher.faults.incident.run_folder import RunFolder
    from launcher.faults.incident.stories import IncidentStory

COMMAND = Command(
    "incident",
    VERBS["incident"],
    synopsis="[ID|last] [options]",
    arguments=(
        option(
            "[ID]",
            "number of an incident, name of a snapshot or its beginning, or `last`",
            name="id",
        ),
    ),
    about="""\
Without ID, list the incidents of the newest run, and its snapshots. With ID, write one HTML file
with cause, faults, timeline, graph, charts, log, plan and bag, which opens without a network.""",
    options=(
        option(
            "--run RUN",
            "id, pid, target or log folder of a run that lives or is over, or the beginning of one",
        ),
        option("--snapshot FOLDER", "make the incident of this snapshot of the flight recorder"),
        option("-o FILE", "the file to write, instead of incident-ID.html", name="file"),
        option("--bag", "copy the bag beside the file, as FILE without .html and with -bag"),
        option("--open", "open the file in the browser"),
        JSON,
        DEBUG,
    ),
)


def main(words: Sequence[str]) -> int:
    """List incidents, or write one; the exit code."""
    options = COMMAND.parse(words)
    from launcher.faults.incident import run_folder, stories

    folder: RunFolder | None = None
    if options.snapshot is not None:
        if options.id is not None:
            raise UsageError("--snapshot and ID exclude each other")
        folder = _around(options)
        return _write(
            stories.of_snapshot(os.path.realpath(options.snapshot), folder), folder, options
        )
    folder = run_folder.find(options.run, _warn)
    found = stories.stories(folder, _warn)
    if options.id is None:
        return _list(found, folder, options)
    story = stories.choose(found, options.id, folder)
    return _write(stories.whole(story, folder), folder, options)


def _around(options: Parsed) -> RunFolder | None:
    """The run of a snapshot: that of --run, else the folder that it is in."""
    from launcher.faults.incident import run_folder
    from launcher.faults.incident.document import IncidentError

    if options.run is not None:
        return run_folder.find(options.run, _warn)
    parent = os.path.dirname(os.path.dirname(os.path.realpath(options.snapshot)))
    try:
        return run_folder.find(parent, _warn)
    except IncidentError:
        return None


def _warn(text: str) -> None:
    print(f"note: {escape(text)}", file=sys.stderr)


# ---- the list


def _list(found: list[IncidentStory], folder: RunFolder, options: Parsed) -> int:
    if options.file or options.bag or options.open:
        raise UsageError("which incident?", hint="name an ID, or `last`")
    if options.json:
        documents = [_row_document(one) for one in found]
        print_document({"log_dir": folder.path, "incidents": documents})
        return ExitCode.OK
    if not found:
        print(f"no incidents and no snapshots in {folder.path}")
        return ExitCode.OK
    rows = [("ID", "TIME", "LASTED", "FAULTS", "TITLE"), *map(_row, found)]
    print("\n".join(aligned([[escape(word, keep="") for word in row] for row in rows], right=(3,))))
    return ExitCode.OK


def _row(story: IncidentStory) -> tuple[str, ...]:
    incident = story.incident
    when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(incident.opened_s))
    return (story.id, when, _lasted(story), str(len(incident.faults)), incident.title)


def _lasted(story: IncidentStory) -> str:
    if story.is_snapshot:
        return "-"
    closed_s = story.incident.closed_s
    return "open" if closed_s is None else f"{closed_s - story.incident.opened_s:.1f} s"


def _row_document(story: IncidentStory) -> dict[str, Any]:
    incident = story.incident
    return {
        "id": story.id,
        "is_snapshot": story.is_snapshot,
        "path": story.path,
        "opened_s": incident.opened_s,
        "closed_s": incident.closed_s,
        "title": incident.title,
        "faults": [one.fault for one in incident.faults],
    }


# ---- one incident


def _write(story: IncidentStory, folder: RunFolder | None, options: Parsed) -> int:
    from launcher.faults.incident.completion import completed

    for problem in story.incident.problems:
        _warn(problem)
    if options.json:
        print_document({"incident": story.incident.raw})
        return ExitCode.OK
    path = options.file or f"incident-{story.id}.html"
    text = _page(completed(story.incident, folder), folder, path, options)
    from launcher.faults.incident.document import IncidentError

    try:
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise IncidentError(f"cannot write {path}: {error.strerror or error}") from None
    print(f"wrote {path}", flush=True)
    if options.open:
        browse(f"file://{os.path.abspath(path)}")
    return ExitCode.OK


def _page(incident: IncidentDocument, folder: RunFolder | None, path: str, options: Parsed) -> str:
    from launcher.faults.incident import bag_place, page
    from launcher.faults.incident.completion import plan_of
    from launcher.faults.incident.markup import EMPTY

    stem = os.path.splitext(path)[0]
    body = page.render(incident, plan_of(incident, folder))
    found = bag_place.find(incident, folder)
    if found is None:
        if options.bag:
            _warn("there is no bag: it needs --record")
        return page.document(incident, body, EMPTY)
    room = page.MAX_BYTES - len(page.document(incident, body, EMPTY).encode())
    place = bag_place.place(found, room, f"{stem}-bag" if options.bag else None)
    if place.archive is None and place.beside is None:
        _warn(f"the bag is too large for the file, and stays in {found}: --bag copies it beside")
    return page.document(incident, body, place.markup(os.path.basename(stem)))
