"""Which shared memory is stale, with real locks in a temporary folder."""

from __future__ import annotations

import contextlib
import fcntl
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from launcher.posix import proc
from launcher.run.monitor import shared_memory
from launcher.run.monitor.ledger import CLOCK_TICK_S, STALE_NEWS_S, Ledger
from launcher.run.monitor.shared_memory import SETTLING_S, Stale, free, held, stale
from tests.support.examples import examples
from tests.support.waiting import wait_until

SEGMENT = "fastrtps_0123456789abcdef"
OTHER = "fastrtps_fedcba9876543210"
PORT = "fastrtps_port7411"
OWNER = 4242
MUTEX = f"sem.{PORT}_mutex"
UNLOCKED, LOCKED = b"\1" + bytes(31), bytes(32)  # contents of a semaphore


class Shelf:
    """A /dev/shm and a /proc of the test's own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.proc = folder / "shm", folder / "proc"
        self.folder.mkdir()
        self.proc.mkdir()
        self._locks = contextlib.ExitStack()
        self._locks.enter_context(mock.patch.object(proc, "ROOT", str(self.proc)))
        self._files = contextlib.ExitStack()
        self._lines = ""

    def put(self, *names: str) -> None:
        for name in names:
            content = UNLOCKED if name.startswith("sem.") else b"x" * 5000
            (self.folder / name).write_bytes(b"" if name.endswith("l") else content)

    def lock(self, name: str, mode: int = fcntl.LOCK_EX, *, pid: int | None = OWNER) -> None:
        """Lock a file; /proc/locks says that `pid` did, or nothing at all."""
        file = self._files.enter_context((self.folder / name).open("rb"))
        fcntl.flock(file, mode)
        if pid is not None:
            at = os.fstat(file.fileno())
            device = f"{os.major(at.st_dev):02x}:{os.minor(at.st_dev):02x}"
            self._lines += f"1: FLOCK  ADVISORY  WRITE {pid} {device}:{at.st_ino} 0 EOF\n"
            (self.proc / "locks").write_text(self._lines)

    def maps(self, *names: str, pid: int = OWNER, run_id: str = "") -> None:
        """What `pid` has mapped, and which run it belongs to."""
        (self.proc / str(pid)).mkdir(exist_ok=True)
        lines = [f"7f00-7f01 rw-s 0 00:1b 1   {self.folder / name}\n" for name in names]
        (self.proc / str(pid) / "maps").write_text("".join(lines))
        (self.proc / str(pid) / "environ").write_text(f"A=1\0LAUNCHER_RUN_ID={run_id}\0")

    def stale(self, age_s: float = 2 * SETTLING_S) -> list[str]:
        """Names of what is stale when the newest file is that old."""
        now_s = max(path.lstat().st_ctime for path in self.folder.iterdir()) + age_s
        return [s.name for s in stale(folder=self.folder, now_s=now_s)]

    def free(self, *names: str) -> int:
        return free(names, folder=self.folder)

    @property
    def left(self) -> set[str]:
        return set(os.listdir(self.folder))

    def release(self) -> None:
        """All locks."""
        self._files.close()
        self._lines = ""
        (self.proc / "locks").write_text("")

    def close(self) -> None:
        self._files.close()
        self._locks.close()


@pytest.fixture
def shelf(tmp_path: Path) -> Iterator[Shelf]:
    one = Shelf(tmp_path)
    yield one
    one.close()


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


def test_what_is_too_young_to_know_is_waited_for(shelf: Shelf, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(shared_memory, "SETTLING_S", 0.1)
    shelf.put(SEGMENT, f"{SEGMENT}_el")
    assert [one.name for one in shared_memory.settled(folder=shelf.folder)] == [SEGMENT]


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
