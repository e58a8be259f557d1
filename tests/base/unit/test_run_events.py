"""Every kind of event is read as it was written, and every reader knows all of them.

New types are covered by themselves: examples are made from the types of their fields.
"""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from launcher.bag import snapshot_folder
from launcher.base import strict_json
from launcher.base.model.event_entries import FIELD_TYPES, annotations_of, entry_in, entry_of
from launcher.base.model.events import signal_name
from launcher.base.model.run_event import TYPES, Entry, RunEvent, UnknownEvent, fields_of
from launcher.base.model.run_events import Resources, Sample, Signalled
from launcher.control.answer_lines import event_line
from launcher.hosts.agent.workload import AgentRunLog
from launcher.launch.analyze import timeline, timeline_report
from launcher.output.logs.event_log import EventLog
from launcher.smoke.observe import log_files
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import Facts
from launcher.smoke.reports import html_report, page_processes
from launcher.smoke.reports.result import SmokeResult
from launcher.web.hub import Hub, PageOutbox
from launcher.web.run_feed import RunFeed
from tests.smoke.unit.facts import verdict
from tests.support.repository import REPOSITORY
from tests.support.run_events import (
    T0,
    entries_of,
    entry,
    event,
    line,
    odd_items,
    odd_lines,
    variants,
)

EVERY = pytest.mark.parametrize("cls", TYPES.values(), ids=list(TYPES))
MARKS = REPOSITORY / "launcher/web/page/timeline/marks.js"
BAD_WORDS = re.compile(r"\bNone\b|undefined|\bnan\b|<launcher|object at")


# ---- the schema


@EVERY
def test_a_type_has_a_docstring_and_fields_of_known_types(cls: type[RunEvent]):
    assert cls.__doc__ and cls.about in ("process", "run", "either")
    for name, annotation in annotations_of(cls).items():
        kind, _, optional = annotation.partition(" | ")
        assert kind in FIELD_TYPES and optional in ("", "None")
        assert re.search(rf"^    {name}: ", cls.__doc__, re.M), f"{name} is not documented"


@pytest.mark.parametrize("cls", [*TYPES.values(), Sample], ids=lambda cls: cls.__name__)
def test_one_name_has_one_type_and_says_its_unit(cls: type[Any]):
    types = {
        (name, annotation.partition(" | ")[0])
        for one in (*TYPES.values(), Sample)
        for name, annotation in annotations_of(one).items()
    }
    for name, kind in {(n, a.partition(" | ")[0]) for n, a in annotations_of(cls).items()}:
        others = {other for same, other in types if same == name} - {kind}
        # The processes of a sample are a number, those of an event names.
        assert not others or name == "processes", name
        units = {"_s": "Seconds", "_bytes": "Size", "_percent": "Percent"}
        assert {unit for end, unit in units.items() if name.endswith(end)} <= {kind}, name
        assert kind not in units.values() or name.endswith(tuple(units)), name


# ---- writing and reading


@EVERY
def test_an_entry_is_read_as_it_was_written(cls: type[RunEvent]):
    for one in variants(cls):
        written: list[bytes] = []
        heard: list[str] = []
        log = EventLog(written.append)
        log.listeners.append(heard.append)
        subject = {"process": "a-1", "host": "bot1"} if cls.about == "process" else {}
        log.note(one, 5.0, **subject)
        log.flush()
        (text,) = b"".join(written).decode().splitlines()
        assert [text] == heard == log.history()
        found = entry_in(text)
        assert found is not None
        assert repr(found.event) == repr(one).replace(r"\udcff", "\ufffd")
        assert (found.monotonic_s, found.process, found.host) == (
            5.0, subject.get("process"), subject.get("host")
        )  # fmt: skip


def test_what_has_its_default_is_left_out_and_what_is_unknown_is_null():
    item = entry(event("started", pid=7, restarts=0)).item
    assert item == {
        "wall_s": T0, "monotonic_s": 0.0, "event": "started", "process": "a-1", "pid": 7,
        "restarts": 0,
    }  # fmt: skip
    assert entry(event("ended", restart_in_s=None)).item["restart_in_s"] is None


def test_fields_of_a_newer_version_do_no_harm():
    item = {**entry(event("signal", signal=10)).item, "sender": {"uid": 0}}
    found = entry_of(item)
    assert found is not None and found.event == event("signal", signal=10)


def test_what_is_not_as_its_type_is_unknown_and_keeps_its_fields():
    asked = {"event": "asked", "verb": "kill", "signal": "SIGUSR1"}  # as 0.1.0 wrote it at first
    found = entry_of({"wall_s": T0, "monotonic_s": 1.0, "process": "a-1", **asked})
    assert found is not None and found.process == "a-1"
    assert found.event == UnknownEvent("asked", {"verb": "kill", "signal": "SIGUSR1"})
    assert event_line(found.item).endswith(" requested a-1 verb=kill signal=SIGUSR1")


def test_no_odd_line_is_an_error():
    found = [entry_in(text) for text in odd_lines()]
    assert {type(one.event) for one in found if one is not None} >= {UnknownEvent}
    assert None in found
    for text in odd_lines():
        assert entry_in(text.encode()) == entry_in(text) or "NaN" in text


# ---- readers: each gets entries, and returns the texts in which it has told of them


def lines_of_events(entries: Sequence[Entry], folder: Path) -> Iterator[str]:
    """`events` in a shell and in the console."""
    for one in entries:
        yield event_line(json.loads(line(one)))


def index_of_a_snapshot(entries: Sequence[Entry], folder: Path) -> Iterator[str]:
    """The flight recorder's folder."""
    run = folder / "run"
    run.mkdir()
    (run / "events.jsonl").write_text("\n".join(map(line, entries)))
    contents = snapshot_folder.SnapshotContents(
        reason="x", end_ns=round((T0 + 3600) * 1e9), keep_s=7200.0, topics=[], messages=[],
        run_folder=str(run),
    )  # fmt: skip
    snapshot_folder.write(str(folder / "found"), contents)
    kept = (folder / "found" / "events.jsonl").read_text()
    assert kept == "".join(f"{line(one)}\n" for one in entries)
    index = (folder / "found" / "index.txt").read_text()
    return iter(index.partition("before the end\n")[2].partition("\n\n")[0].split("\n"))


def items_of_the_page(entries: Sequence[Entry], folder: Path) -> Iterator[str]:
    """The server of the page in the browser, and the page of a smoke report."""
    told = asyncio.run(_sent([json.loads(line(one)) for one in entries]))
    facts = _facts(entries, folder)
    messages = json.loads(strict_json.dumps(html_report.messages(_result(facts), "x.launch.py")))
    (frozen,) = [one["items"] for one in messages if one["event"] == "run_events"]
    assert [one["text"] for one in frozen] == [one["text"] for one in told]
    for one in told:
        yield f"{one.get('process') or ''} {one['event']}: {one['text']}"


async def _sent(items: Sequence[Any]) -> list[dict[str, Any]]:
    """The items that a page gets when the run has told these."""
    page, hub = PageOutbox(), Hub(lambda: None)
    hub.join(page)
    feed = RunFeed(hub, lambda: None)
    feed.rows = [{"name": "a-1", "state": "RUNNING"}]
    for item in items:
        feed._take_event(item)
    found: list[dict[str, Any]] = []
    while len(found) < len(feed.events):
        found += json.loads(await page.get())["items"]
    return found


def judges_of_smoke(entries: Sequence[Entry], folder: Path) -> Iterator[str]:
    """Its judges and the rows of its report."""
    facts = _facts(entries, folder)
    for wanted in ("process: a-1", "process: a-1, exits: 0", "process: a-1, restarts: 0",
                   "ready: '*'", "no_deaths: '*'", "clean_shutdown: 5 s"):  # fmt: skip
        found = verdict(wanted, events=facts.events)
        assert not BAD_WORDS.search(f"{found.seen} {found.guess or ''}")
    json.dumps(page_processes.rows_of(_result(facts), {}, {}))
    json.dumps(page_processes.history_of(facts, T0))
    facts.unready()
    for one, written in zip(facts.events, entries, strict=True):
        assert (one.host, repr(one.event)) == (written.host, repr(written.event))  # NaN != NaN
        assert one.details.keys() >= fields_of(written.event).keys()
        yield f"{one.process or ''} {one.kind} {json.dumps(dict(one.details), default=vars)}"


def _facts(entries: Sequence[Entry], folder: Path) -> Facts:
    (folder / "events.jsonl").write_text("\n".join(map(line, entries)))
    recorder = FactRecorder()
    recorder.begin()
    for one in log_files.events(folder, recorder):
        recorder.add(one)
    return recorder.facts()


def _result(facts: Facts) -> SmokeResult:
    return SmokeResult(
        judged=(), facts=facts, started_s=T0, folder=Path("x"), words=("x",), domain_id=1
    )


def reports_of_analyze(entries: Sequence[Entry], folder: Path) -> Iterator[str]:
    start = entry(event("started"))
    (folder / "events.jsonl").write_text("\n".join(map(line, [start, *entries])))
    found = timeline.read(str(folder))
    assert list(found.processes) == ["a-1"]
    assert found.until_s == pytest.approx(max(one.wall_s for one in entries) - T0, abs=1e-3)
    texts = timeline_report.lines(found, 80)
    json.dumps(timeline_report.document(found))
    assert not BAD_WORDS.search("\n".join(texts))
    return iter([f"a-1 {one.event.event}" for one in entries])  # it shows times only


Reader = Callable[[Sequence[Entry], Path], Iterator[str]]
READERS: list[Reader] = [
    lines_of_events, index_of_a_snapshot, items_of_the_page, judges_of_smoke, reports_of_analyze,
]  # fmt: skip
ALL = pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.__name__)


@ALL
@EVERY
def test_every_reader_knows_every_event(reader: Reader, cls: type[RunEvent], tmp_path: Path):
    entries = entries_of(cls)
    texts = list(reader(entries, tmp_path))
    if cls is Resources and reader is not lines_of_events:
        return  # samples are shown as curves and columns, if at all
    assert len(texts) == len(entries)
    for one, text in zip(entries, texts, strict=True):
        assert text.isprintable() or reader is items_of_the_page, ascii(text)
        assert not BAD_WORDS.search(text.replace("null", ""))
        if one.process is not None:
            assert one.process in text


@ALL
def test_no_reader_ends_at_an_odd_line(reader: Reader, tmp_path: Path):
    odd = [one for text in odd_lines() if (one := entry_in(text)) is not None]
    assert odd
    assert list(reader(odd, tmp_path))


def test_lines_that_are_no_entries_are_left_out_of_what_is_read_from_files(tmp_path: Path):
    whole = entry(event("started"), at_s=1.0)
    texts = [*odd_lines(), line(whole)]
    (tmp_path / "events.jsonl").write_text("\n".join(texts), encoding="utf-8")
    with (tmp_path / "events.jsonl").open("ab") as file:
        file.write(b"\n\xff\xfe{\0}\0\n" + line(whole).encode()[:40])
    assert timeline.read(str(tmp_path)).processes["a-1"].started_s == pytest.approx(1.0)
    recorder = FactRecorder()
    known = [one for text in texts if (one := entry_in(text)) is not None]
    assert [one.event for one in log_files.events(tmp_path, recorder)] == [x.event for x in known]


def test_what_is_no_entry_is_shown_as_it_is():
    for item in odd_items():
        if isinstance(item, dict):
            shown = event_line(item)
            assert shown.isprintable()
            assert entry_of(item) is not None or shown == strict_json.dumps(item)
    told = asyncio.run(_sent([{"dropped": 3}, {"wall_s": None}]))
    assert [one["text"] for one in told] == [
        "(3 events were not read in time)", '{"wall_s": null}'
    ]  # fmt: skip


def test_signals_have_their_names_wherever_they_are_shown(tmp_path: Path):
    for signum in (10, 40):
        sent = [entry(event("signal", signal=signum)), entry(event("asked", signal=signum)),
                entry(event("ended", returncode=-signum))]  # fmt: skip
        assert all(f"={signal_name(signum)}" in text for text in lines_of_events(sent, tmp_path))
        assert all(signal_name(signum) in one.sentence for one in sent)


@EVERY
def test_an_agent_passes_on_samples_and_leaves_events_to_the_operator(cls: type[RunEvent]):
    samples: list[Any] = []
    log = AgentRunLog(lambda text: pytest.fail(text), samples.append)
    for one in variants(cls):
        log.note(one, None)
    assert bool(samples) is (cls is Resources)


def test_the_page_has_a_mark_for_every_event_that_it_gets():
    table = MARKS.read_text(encoding="utf-8").partition("const MARKS = {")[2].partition("\n};")[0]
    marked = set(re.findall(r'^  "?([a-z ]+)"?: \[', table, re.M))
    assert marked - {"expectation", "launch file"} == TYPES.keys() - {Resources.event}


def test_deaths_are_what_the_flight_recorder_waits_for():
    assert event("not started").is_failure and event("ended", returncode=-9).is_failure
    assert not event("ended", returncode=-2, asked=True).is_failure
    assert not event("ended", returncode=0).is_failure and not Signalled(1, 9).is_failure
