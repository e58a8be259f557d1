"""What a run records of its shared memory, and frees of it."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from launcher.run.monitor import shared_memory
from launcher.run.monitor.ledger import CLOCK_TICK_S, STALE_NEWS_S, Ledger
from launcher.run.monitor.shared_memory import SETTLING_S, held, stale
from tests.run.unit.shared_memory.shelf import MUTEX, OTHER, PORT, SEGMENT, Shelf
from tests.support.waiting import wait_until


def test_a_folder_that_is_not_there_holds_nothing(tmp_path: Path):
    assert stale(folder=tmp_path / "nope") == []
    ledger = Ledger("1-a", folder=tmp_path / "nope")
    ledger.note()
    assert ledger.free() == 0


def wait_a_moment() -> None:
    """Until files get another time."""
    later_s = time.time() + 3 * CLOCK_TICK_S
    wait_until(lambda: time.time() > later_s, "it is another moment")


def test_the_tracker_frees_what_its_run_held_and_nothing_else(shelf: Shelf):
    for name, pid, run_id in ((SEGMENT, 11, "1-a"), (OTHER, 12, "1-b")):
        shelf.put(name, f"{name}_el")
        shelf.lock(f"{name}_el", pid=pid)
        shelf.maps(name, pid=pid, run_id=run_id)
    assert held(folder=shelf.folder) == {SEGMENT: 11, OTHER: 12}
    ledger = Ledger("1-a", folder=shelf.folder)
    ledger.note()
    assert (ledger.names, ledger.free()) == ({SEGMENT}, 0)
    shelf.close()  # both die
    assert ledger.free() == 0  # nothing has been said of it
    wait_a_moment()  # that of the other run is not from the life of ours
    ledger.died(-9, time.time())
    assert ledger.free() >= 5000
    assert (ledger.names, shelf.left) == (set(), {OTHER, f"{OTHER}_el"})


def test_at_the_end_all_recorded_segments_are_freed_but_ports_only_beside_one(shelf: Shelf):
    shelf.put(PORT, f"{PORT}_el", SEGMENT, f"{SEGMENT}_el")
    shelf.lock(f"{PORT}_el", pid=11)
    shelf.maps(PORT, pid=11, run_id="1-a")
    port_only = Ledger("1-a", folder=shelf.folder)
    port_only.note()
    shelf.lock(f"{SEGMENT}_el", pid=11)
    both = Ledger("1-a", folder=shelf.folder)
    both.note()
    shelf.close()  # it exits with code 0
    port_only.free(is_last=True)
    assert PORT in shelf.left
    assert both.free() == 0
    both.free(is_last=True)
    assert shelf.left == set()


def unrecorded(shelf: Shelf) -> Ledger:
    """SEGMENT was made by a process that has died since."""
    ledger = Ledger("1-a", folder=shelf.folder)
    shelf.put(SEGMENT, f"{SEGMENT}_el")
    ledger.died(1, time.time() - 60.0)
    return ledger


def test_a_segment_of_a_process_that_died_young_is_freed(shelf: Shelf):
    assert unrecorded(shelf).free() >= 5000
    assert shelf.left == set()


def test_a_lock_file_that_may_be_about_to_be_locked_stays(shelf: Shelf):
    ledger = unrecorded(shelf)
    (shelf.folder / SEGMENT).unlink()
    assert ledger.free(is_last=True) == 0
    assert shelf.left == {f"{SEGMENT}_el"}


def test_a_locked_segment_from_the_life_of_a_dead_process_stays(shelf: Shelf):
    ledger = unrecorded(shelf)
    shelf.lock(f"{SEGMENT}_el", pid=None)
    assert ledger.free(is_last=True) == 0
    assert shelf.left == {SEGMENT, f"{SEGMENT}_el"}


@pytest.mark.parametrize("code", [1, 137, -9])
def test_ports_are_freed_after_a_death_by_a_signal_also_without_a_segment(shelf: Shelf, code: int):
    shelf.put(PORT, f"{PORT}_el")
    shelf.lock(f"{PORT}_el", pid=11)
    shelf.maps(PORT, pid=11, run_id="1-a")
    ledger = Ledger("1-a", folder=shelf.folder)
    ledger.note()
    shelf.close()
    ledger.died(code, time.time() - 60.0)
    assert (ledger.free() > 0) == (code != 1)


SHARED_PORT = "fastrtps_port7002"


def used_ports(shelf: Shelf) -> Ledger:
    """Of a run whose processes have ended; what they used has been made again by senders."""
    ledger = Ledger("1-a", folder=shelf.folder)
    used = ("fastrtps_port7425", SHARED_PORT)
    shelf.put(*used, *(f"{name}_el" for name in used))
    for name in used:
        shelf.lock(f"{name}_el", pid=11)
    shelf.maps(*used, pid=11, run_id="1-a")
    ledger.note()
    shelf.release()
    for name in used:
        (shelf.folder / f"{name}_el").unlink()
    shelf.put(PORT, MUTEX)
    return ledger


def test_when_the_helpers_have_ended_ports_that_nobody_uses_are_freed(
    shelf: Shelf, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(shared_memory, "SETTLING_S", 0.0)
    shelf.put("fastrtps_port7003", "fastrtps_port7003_el")  # before the run
    wait_a_moment()
    used_ports(shelf).release()
    assert shelf.left == {"fastrtps_port7003", "fastrtps_port7003_el"}


def test_what_a_helper_leaves_that_was_killed_at_once_is_freed(shelf: Shelf):
    ledger = Ledger("1-a", folder=shelf.folder)
    shelf.put(SEGMENT, f"{SEGMENT}_el", PORT, f"{PORT}_el", MUTEX)
    ledger.release()
    assert not shelf.left


def test_ports_that_others_use_stay_when_the_helpers_have_ended(shelf: Shelf):
    ledger = used_ports(shelf)
    shelf.put(OTHER, f"{OTHER}_el", "fastrtps_port7427", "fastrtps_port7427_el")
    shelf.lock(f"{OTHER}_el", pid=12)
    shelf.lock("fastrtps_port7427_el", pid=12)
    shelf.maps(OTHER, PORT, SHARED_PORT, pid=12, run_id="1-b")
    ledger.release()
    assert "fastrtps_port7425" not in shelf.left
    assert {PORT, MUTEX, SHARED_PORT, "fastrtps_port7427"} <= shelf.left


def test_a_child_of_a_helper_is_of_the_run(shelf: Shelf):
    for pid, parent, name in ((11, os.getpid(), SEGMENT), (12, 11, OTHER), (13, 1, "fastrtps_3")):
        shelf.put(name, f"{name}_el")
        shelf.lock(f"{name}_el", pid=pid)
        shelf.maps(name, pid=pid)
        (shelf.proc / str(pid) / "environ").write_bytes(b"A=1\0")
        (shelf.proc / str(pid) / "status").write_text(f"PPid:\t{parent}\n")
    ledger = Ledger("1-a", folder=shelf.folder)
    ledger.helper_pids.add(11)
    ledger.note()
    assert ledger.names == {SEGMENT, OTHER}


@pytest.mark.parametrize("is_older", [True, False])
def test_a_segment_that_is_not_from_the_life_of_a_dead_process_stays(shelf: Shelf, is_older: bool):
    ledger = Ledger("1-a", folder=shelf.folder)
    steps = [lambda: shelf.put(SEGMENT, f"{SEGMENT}_el"), lambda: ledger.died(1, time.time())]
    first, second = steps if is_older else reversed(steps)
    first()
    wait_a_moment()
    second()
    assert ledger.free(is_last=True) == 0
    assert SEGMENT in shelf.left


def keep_up(ledger: Ledger, now: float) -> None:
    ledger.keep_up(now)
    wait_until(lambda: ledger.collect() or not ledger.is_reading, "the locks are read")


def test_the_tracker_follows_new_files_and_rechecks_old_ones_rarely(
    shelf: Shelf,
):
    ledger = Ledger("1-a", folder=shelf.folder)
    for pid in (11, 12):
        shelf.maps(SEGMENT, pid=pid, run_id="1-a")
    shelf.put(SEGMENT, f"{SEGMENT}_el", OTHER, f"{OTHER}_el")
    shelf.lock(f"{SEGMENT}_el", pid=11)
    keep_up(ledger, 100.0)
    assert ledger.names == {SEGMENT}
    shelf.lock(f"{OTHER}_el", pid=12)  # its file was there before
    keep_up(ledger, 100.0 + SETTLING_S)
    assert ledger.names == {SEGMENT}
    keep_up(ledger, 100.0 + 2 * STALE_NEWS_S)
    assert ledger.names == {SEGMENT, OTHER}


def test_the_tracker_does_not_wait_for_the_kernel_once_a_second(shelf: Shelf):
    shelf.maps(SEGMENT, pid=11, run_id="1-a")
    ledger = Ledger("1-a", folder=shelf.folder)
    shelf.put(SEGMENT, f"{SEGMENT}_el")
    shelf.lock(f"{SEGMENT}_el", pid=11)
    locks = shelf.proc / "locks"
    text = locks.read_text()
    locks.unlink()
    os.mkfifo(locks)  # a reader waits until somebody writes
    for now in (100.0, 100.5, 101.0):
        ledger.keep_up(now)
        ledger.collect()
        assert ledger.is_reading and not ledger.names
    locks.write_text(text)
    wait_until(lambda: ledger.collect() or not ledger.is_reading, "the locks are read")
    assert ledger.names == {SEGMENT}
