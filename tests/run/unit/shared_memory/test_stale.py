"""Which shared memory is stale, with real locks in a temporary folder."""

from __future__ import annotations

import contextlib
import fcntl
import tempfile
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from launcher.run.monitor import shared_memory
from launcher.run.monitor.shared_memory import Stale, free, stale
from tests.run.unit.shared_memory.shelf import (
    LOCKED,
    MUTEX,
    OTHER,
    OWNER,
    PORT,
    SEGMENT,
    UNLOCKED,
    Shelf,
)
from tests.support.examples import examples


def test_a_segment_whose_lock_nobody_holds_is_stale(shelf: Shelf):
    shelf.put(SEGMENT, f"{SEGMENT}_el")
    assert shelf.stale() == [SEGMENT]
    assert shelf.free(SEGMENT) >= 5000
    assert shelf.left == set()


def test_a_segment_whose_lock_is_held_stays(shelf: Shelf):
    shelf.put(SEGMENT, f"{SEGMENT}_el")
    shelf.lock(f"{SEGMENT}_el", pid=None)  # by somebody in another namespace
    assert shelf.stale() == []
    assert shelf.free(SEGMENT) == 0
    assert shelf.left == {SEGMENT, f"{SEGMENT}_el"}


@pytest.mark.parametrize("names", [(SEGMENT, f"{SEGMENT}_el"), (PORT,)], ids=["segment", "port"])
def test_what_was_just_made_is_not_stale_yet(shelf: Shelf, names: tuple[str, ...]):
    shelf.put(*names)
    assert shelf.stale(age_s=0) == []
    assert len(shelf.stale()) == 1


def test_what_fast_dds_does_not_lock_is_left_alone(shelf: Shelf):
    strangers = {SEGMENT, "fast_datasharing_01.0f_0", "sem.other", "lttng-ust-wait-6", f"{OTHER}x"}
    shelf.put(*strangers)
    assert shelf.stale() == []
    assert shelf.free(*strangers) == 0
    assert shelf.left == strangers


def test_a_lock_that_may_not_be_tested_counts_as_held(shelf: Shelf):
    shelf.put(SEGMENT, "elsewhere")
    (shelf.folder / f"{SEGMENT}_el").symlink_to(shelf.folder / "elsewhere")
    assert shelf.stale() == []


def test_an_unused_port_is_removed_with_its_semaphore(shelf: Shelf):
    files = {PORT, f"{PORT}_el", MUTEX}
    shelf.put(*files)
    assert shelf.stale() == [PORT]
    shelf.free(PORT)
    assert shelf.left == set()


@pytest.mark.parametrize("content", [LOCKED, b""], ids=["locked", "cut off"])
def test_a_port_that_somebody_opens_or_removes_stays(shelf: Shelf, content: bytes):
    shelf.put(PORT, f"{PORT}_el", MUTEX)
    (shelf.folder / MUTEX).write_bytes(content)
    assert shelf.free(PORT) == 0
    assert shelf.left == {PORT, f"{PORT}_el", MUTEX}
    (shelf.folder / MUTEX).write_bytes(UNLOCKED)
    assert shelf.free(PORT) > 0
    assert shelf.left == set()


def test_a_port_that_was_mapped_before_its_mutex_was_taken_stays(
    shelf: Shelf, monkeypatch: pytest.MonkeyPatch
):
    """Its file would be removed, and what is written to a new one would not be received."""
    shelf.put(PORT, f"{PORT}_el", MUTEX, SEGMENT, f"{SEGMENT}_el")
    shelf.lock(f"{SEGMENT}_el")
    shelf.maps(SEGMENT)
    take = shared_memory._mutex

    def late(folder: Path, port: str) -> contextlib.AbstractContextManager[None]:
        shelf.maps(SEGMENT, PORT)
        return take(folder, port)

    monkeypatch.setattr(shared_memory, "_mutex", late)
    assert shelf.free(PORT) == 0
    assert PORT in shelf.left
    assert (shelf.folder / MUTEX).read_bytes() == UNLOCKED


@pytest.mark.parametrize("file", [PORT, MUTEX, f"{PORT}_sl"])
def test_what_is_left_of_a_port_is_found_by_any_of_its_files(shelf: Shelf, file: str):
    shelf.put(file)
    assert shelf.stale() == [PORT]


@pytest.mark.parametrize(
    ("suffix", "mode"), [("_el", fcntl.LOCK_EX), ("_sl", fcntl.LOCK_SH)], ids=["one", "shared"]
)
def test_a_port_that_is_read_stays(shelf: Shelf, suffix: str, mode: int):
    shelf.put(PORT, f"{PORT}{suffix}")
    shelf.lock(f"{PORT}{suffix}", mode)
    assert shelf.stale() == []
    assert shelf.free(PORT) == 0


def test_a_port_that_a_live_participant_writes_to_stays(shelf: Shelf):
    shelf.put(PORT, "fastrtps_port7413", SEGMENT, f"{SEGMENT}_el")
    shelf.lock(f"{SEGMENT}_el")
    shelf.maps(SEGMENT, PORT)
    assert shelf.stale() == ["fastrtps_port7413"]
    assert shelf.free(PORT) == 0


@pytest.mark.parametrize("pid", [None, OWNER], ids=["other namespace", "other user"])
def test_no_port_is_stale_while_a_participant_cannot_be_looked_at(shelf: Shelf, pid: int | None):
    shelf.put(PORT, SEGMENT, f"{SEGMENT}_el", OTHER, f"{OTHER}_el")
    shelf.lock(f"{SEGMENT}_el", pid=pid)
    assert shelf.stale() == [OTHER]
    assert shelf.free(PORT) == 0


def test_no_port_is_freed_while_a_participant_may_be_starting(
    shelf: Shelf, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(shared_memory, "SETTLING_S", 3600.0)
    shelf.put(PORT, SEGMENT, f"{SEGMENT}_el")
    assert shelf.free(PORT) == 0
    assert shelf.left == {PORT, SEGMENT, f"{SEGMENT}_el"}


def test_the_port_of_a_short_lived_node_is_removed_with_its_segment(shelf: Shelf):
    shelf.put(PORT, SEGMENT, f"{SEGMENT}_el")
    shelf.free(PORT, SEGMENT)
    assert shelf.left == set()


def test_what_came_into_use_after_it_was_found_is_not_cleaned(shelf: Shelf):
    shelf.put(SEGMENT, f"{SEGMENT}_el")
    found = stale(folder=shelf.folder, now_s=time.time() + 60)
    shelf.lock(f"{SEGMENT}_el")
    assert free((item.name for item in found), folder=shelf.folder) == 0
    assert shelf.left == {SEGMENT, f"{SEGMENT}_el"}


def test_what_is_too_young_to_know_is_waited_for(shelf: Shelf, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(shared_memory, "SETTLING_S", 0.1)
    shelf.put(SEGMENT, f"{SEGMENT}_el")
    assert [one.name for one in shared_memory.settled(folder=shelf.folder)] == [SEGMENT]


def test_a_found_item_knows_whether_it_is_a_port():
    assert [Stale(name, 1).is_port for name in (PORT, SEGMENT)] == [True, False]


NAMES = st.sampled_from([SEGMENT, OTHER, PORT, "fastrtps_port7413", "fastdds_0000000000000001"])


@settings(max_examples=examples(40))
@given(present=st.sets(NAMES), locked=st.sets(NAMES), visible=st.booleans())
def test_cleaning_never_touches_what_is_locked(present: set[str], locked: set[str], visible: bool):
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        shelf = Shelf(Path(folder))
        stack.callback(shelf.close)
        shelf.put(*present, *(f"{name}_el" for name in present))
        for name in present & locked:
            shelf.lock(f"{name}_el", pid=OWNER if visible else None)
        shelf.maps("fastrtps_port7413")
        found = stale(folder=shelf.folder, now_s=time.time() + 60)
        free((item.name for item in found), folder=shelf.folder)
        assert {f"{name}_el" for name in present & locked} <= shelf.left
        assert {n for n in present - locked if "port" not in n}.isdisjoint(shelf.left)
