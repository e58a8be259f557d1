"""The folder of a snapshot: what is in it, and its index."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.bag import snapshot_folder
from launcher.bag.reader import Bag
from launcher.bag.snapshot_folder import SnapshotContents
from launcher.base.model.run_event import Entry
from tests.support.bags import START_NS, message, string_topic
from tests.support.run_events import event, line

LEFT, RIGHT = b"l" * 16, b"r" * 16
END_S = 60.0


def contents(run_folder: Path | None, **more: object) -> SnapshotContents:
    messages = [
        (message("/talk", 10, "old"), LEFT),
        (message("/talk", 50.8, "last of left"), LEFT),
        (message("/talk", 59.5, "last of right"), RIGHT),
        (message("/alone", 40, "x"), b"?" * 16),
    ]
    messages.sort(key=lambda one: one[0].log_ns)
    return SnapshotContents(
        reason="robot_2-4 died (SIGKILL)",
        end_ns=START_NS + round(END_S * 1e9),
        keep_s=30.0,
        topics=[string_topic("/talk"), string_topic("/alone"), string_topic("/silent")],
        messages=messages,
        nodes={LEFT: "/fleet/left", RIGHT: "/right"},
        run_folder=None if run_folder is None else str(run_folder),
        **more,
    )


@pytest.fixture
def run_folder(tmp_path: Path) -> Path:
    """Logs and events of a run, some of them before the span."""
    folder = tmp_path / "run"
    folder.mkdir()
    base = START_NS / 1e9
    events = [
        (5, "robot_2-4", event("started")),
        (55, None, event("resources")),
        (56, "robot_2-4", event("asked", verb="kill")),
        (56.1, "robot_2-4", event("signal", signal=9)),
        (57, "robot_2-4", event("ended", returncode=-9, restart_in_s=None)),
        (90, "later-9", event("started")),
    ]
    lines = [line(Entry(base + at_s, at_s, one, process)) for at_s, process, one in events]
    (folder / "events.jsonl").write_text("\n".join([*lines, '{"wall_s": 17']))
    (folder / "plan.json").write_text("{}")
    (folder / "robot_2-4.log").write_text(
        f"[robot_2-4] [INFO] [{base + 5:.9f}] [robot_2]: before\n"
        f"[robot_2-4] [INFO] [{base + 56:.9f}] [robot_2]: within\n"
        "[robot_2-4] Traceback without a time\n"
    )
    (folder / "launch.log").write_text(f"{base + 1:.7f} [INFO] [launch]: long ago\n")
    (folder / "plain-1.log").write_text("[plain-1] no times at all\n")
    (folder / "python_77_1795793313603.log").write_text("of rcl\n")
    return folder


def test_what_is_in_a_snapshot(tmp_path: Path, run_folder: Path):
    folder = tmp_path / "found"
    snapshot_folder.write(str(folder), contents(run_folder))
    assert sorted(path.name for path in folder.iterdir()) == [
        "bag",
        "events.jsonl",
        "index.txt",
        "logs",
        "plan.json",
    ]
    bag = Bag(str(folder / "bag"))
    assert bag.extent.counts == {"/talk": 3, "/alone": 1}
    assert {topic.name for topic in bag.topics} == {"/talk", "/alone", "/silent"}
    assert bag.metadata.custom_data == {"reason": "robot_2-4 died (SIGKILL)"}
    logs = {path.name: path.read_text() for path in (folder / "logs").iterdir()}
    assert logs.keys() == {"robot_2-4.log", "plain-1.log"}
    assert logs["robot_2-4.log"].endswith(
        "[robot_2]: within\n[robot_2-4] Traceback without a time\n"
    )
    assert "before" not in logs["robot_2-4.log"]


def test_the_index_says_what_happened_when(tmp_path: Path, run_folder: Path):
    snapshot_folder.write(str(tmp_path / "found"), contents(run_folder))
    text = (tmp_path / "found" / "index.txt").read_text()
    _, _, rest = text.partition("seconds before the end\n")
    assert rest.partition("\n\n")[0].splitlines() == [
        "   20.000  last /alone",
        "    9.200  last /talk of left",
        "    4.000  robot_2-4: requested: kill",
        "    3.900  robot_2-4: got SIGKILL",
        "    3.000  robot_2-4: ended (SIGKILL)",
        "    0.500  last /talk of right",
    ]
    assert text.startswith("why: robot_2-4 died (SIGKILL)\nend: ")
    assert "\nspan: the last 30 s\n" in text


def test_a_full_ring_is_told(tmp_path: Path):
    full = contents(None, dropped_ns=START_NS + 45 * 10**9)
    snapshot_folder.write(str(tmp_path / "found"), full)
    text = (tmp_path / "found" / "index.txt").read_text()
    assert "span: the last 30 s; messages of the last 15.0 s, since memory was full\n" in text


def test_an_error_leaves_nothing(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(snapshot_folder, "_copy_plan", lambda folder, contents: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        snapshot_folder.write(str(tmp_path / "found"), contents(None))
    assert list(tmp_path.iterdir()) == []
