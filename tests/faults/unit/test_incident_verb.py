"""`incident`: the incidents and snapshots of runs that are over, and the file of one."""

from __future__ import annotations

import base64
import io
import json
import re
import zipfile
from pathlib import Path
from typing import Any

import pytest

from launcher.bag import snapshot_folder
from launcher.bag.reader import Bag
from launcher.bag.snapshot_folder import SnapshotContents
from launcher.base.model.run_event import Entry
from tests.support.bags import START_NS, message, string_topic
from tests.support.incidents import OPENED_S, incident_document
from tests.support.json_forms import fit
from tests.support.run_events import event, line
from tests.support.verbs import Answer, in_process

NAME = "2026-11-30-16-07-06-952698-vm-18276"
DEATH = "2026-11-30-16-07-26-death"
BASE_S = START_NS / 1e9


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a run that is over, without incidents; the working directory is beside it."""
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    folder = tmp_path / "log" / NAME
    folder.mkdir(parents=True)
    events = [
        (1, "robot_1-3", event("started", pid=7)),
        (55, "robot_1-3", event("asked", verb="kill", signal=9)),
        (55.5, "robot_1-3", event("ended", returncode=-9, asked=False, restart_in_s=None)),
    ]
    lines = [line(Entry(BASE_S + at_s, at_s, one, process)) for at_s, process, one in events]
    (folder / "events.jsonl").write_text("\n".join(lines) + "\n")
    command = ["robot_1", "--token=hunter2"]
    plan = {"processes": [{"label": "robot_1", "cmd": command, "env_set": {"KEY": "hunter2"}}]}
    (folder / "plan.json").write_text(json.dumps(plan))
    (folder / "launch.log").write_text(
        f"{BASE_S + 54:.7f} [robot_1-3] [INFO] [1.0] [robot_1]: the last words\n"
        f"{BASE_S + 55.6:.7f} [ERROR] [robot_1-3]: process has died\n"
    )
    (folder.parent / "latest").symlink_to(folder)
    return folder


def with_incident(run: Path, number: int = 3, **changes: Any) -> None:
    (run / "incidents").mkdir(exist_ok=True)
    text = json.dumps(incident_document(number=number, **changes))
    (run / "incidents" / f"{number}.json").write_text(text)


def with_snapshot(run: Path, size: int = 1) -> Path:
    messages = [(message("/fleet/status", at_s, "x" * size), b"l" * 16) for at_s in (50, 51, 52.5)]
    contents = SnapshotContents(
        reason="robot_1-3 died (SIGKILL)",
        end_ns=START_NS + 56_500_000_000,
        keep_s=30.0,
        topics=[string_topic("/fleet/status")],
        messages=messages,
        nodes={b"l" * 16: "/robot_1"},
        run_folder=str(run),
    )
    path = run / "snapshots" / DEATH
    path.parent.mkdir(exist_ok=True)
    snapshot_folder.write(str(path), contents)
    return path


def say(words: str) -> Answer:
    return in_process(*words.split())


def test_the_list_has_incidents_and_snapshots_in_the_order_of_time(run: Path):
    with_snapshot(run)
    with_incident(run)
    with_incident(run, 4, title="second", opened_s=OPENED_S + 60, closed_s=None)

    found = say("incident").out.splitlines()

    assert found[0].split() == ["ID", "TIME", "LASTED", "FAULTS", "TITLE"]
    listed = sorted(re.split(r"  +", one)[0] for one in found[1:])
    assert listed == sorted(["3", "4", DEATH])
    assert any(one.endswith("3  robot_1-3 was killed by SIGKILL, so /fleet/status of robot_1 fell "
                            "silent") and "8.3 s" in one for one in found)  # fmt: skip


def test_the_list_as_json(run: Path):
    with_snapshot(run)
    with_incident(run)

    (answer,) = fit("incident", say("incident --json").out)

    assert {one["id"]: one["is_snapshot"] for one in answer["incidents"]} == {
        "3": False,
        DEATH: True,
    }


def test_a_snapshot_of_an_incident_is_not_listed_twice(run: Path):
    with_incident(run, snapshot=str(with_snapshot(run)))

    assert DEATH not in say("incident").out


def test_an_incident_becomes_a_file(run: Path):
    with_incident(run)

    assert say("incident 3").out == "wrote incident-3.html\n"

    text = Path("incident-3.html").read_text()
    assert "<h1>robot_1-3 was killed by SIGKILL" in text
    assert "--token=***" in text
    assert "hunter2" not in text


def test_last_is_the_newest(run: Path):
    with_incident(run)
    with_incident(run, 4, title="second", opened_s=OPENED_S + 60)

    say("incident last -o x.html")

    assert "<h1>second</h1>" in Path("x.html").read_text()


def test_the_document_is_printed_without_secrets(run: Path):
    with_incident(run, title="https://me:hunter2@host")

    (answer,) = fit("incident", say("incident 3 --json").out)

    assert answer["incident"]["title"] == "https://***@host"


def test_what_is_wrong_about_a_document_is_said(run: Path):
    with_incident(run, number=3, faults=7)
    (run / "incidents" / "4.json").write_text("{")

    said = say("incident 3").err

    assert "faults: 7 is not a list" in said
    assert "4.json is not the document of an incident" in said
    assert "faults: 7 is not a list" in Path("incident-3.html").read_text()


def test_a_snapshot_becomes_an_incident_with_its_bag(run: Path):
    with_snapshot(run)

    say("incident 2026 -o x.html")

    text = Path("x.html").read_text()
    assert "<h1>robot_1-3 died (SIGKILL)</h1>" in text
    assert "requested: kill with SIGKILL, 0.50 s before it ended" in text
    assert "3 messages" in text
    assert "<mark>[INFO] [1.0] [robot_1]: the last words</mark>" in text
    data = re.search(r'download="x-bag.zip" href="data:application/zip;base64,([^"]+)"', text)
    assert data is not None
    zipfile.ZipFile(io.BytesIO(base64.b64decode(data[1]))).extractall("unpacked")
    assert Bag("unpacked/bag").extent.total == 3


def test_a_snapshot_may_be_anywhere(run: Path, tmp_path: Path):
    path = with_snapshot(run).rename(tmp_path / "moved")

    say(f"incident --snapshot {path}")

    assert "robot_1-3 died" in Path("incident-moved.html").read_text()


def test_a_bag_can_be_copied_beside_the_file(run: Path):
    with_snapshot(run)

    say("incident last --bag -o x.html")

    assert 'href="./x-bag"' in Path("x.html").read_text()
    assert Bag("x-bag").extent.total == 3


@pytest.mark.parametrize("which", [NAME, "18276", "18276-0123abcd", "2026-11-30-16"])
def test_a_run_that_is_over_is_found(run: Path, which: str):
    (run.parent / "latest").unlink()
    with_incident(run)

    assert "\n3 " in say(f"incident --run {which}").out


def test_a_run_is_found_by_its_folder(run: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("ROS_LOG_DIR")
    with_incident(run)

    assert "\n3 " in say(f"incident --run {run}").out


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ("incident 9", "incident '9' is not one of run"),
        ("incident last --run nothing", "unknown run 'nothing'"),
        ("incident --run /", "/ is not the folder of a run"),
        ("incident --snapshot /", "/ is not a snapshot"),
        ("incident 3 -o /nowhere/x.html", "cannot write /nowhere/x.html"),
        ("incident --bag", "which incident?"),
        ("incident 3 --snapshot /", "--snapshot and ID exclude each other"),
    ],
)
def test_mistakes_are_named(run: Path, words: str, problem: str):
    with_incident(run)

    ended = say(words)

    assert ended.code != 0
    assert problem in ended.err


def test_a_run_without_incidents_says_what_it_needs(run: Path):
    assert say("incident").out == f"no incidents and no snapshots in {run}\n"
    assert "--expect or --watchful" in say("incident last").err
