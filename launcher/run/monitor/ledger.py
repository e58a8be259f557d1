"""Which shared memory belongs to a run, so that what its dead processes leave can be freed."""

from __future__ import annotations

import _thread
import contextlib
import os
import time

from launcher.posix import proc
from launcher.posix.cleanup.run_id import run_id_of
from launcher.run.monitor import shared_memory

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.monitor.shared_memory import Folder

CLOCK_TICK_S = 0.01  # times of files are those of the last tick of the kernel, so much too early
STALE_NEWS_S = 30.0  # a port may get another owner without a change in the folder


class Ledger:
    """Shared memory of the processes of one run, recorded while they are running.

    Call `keep_up` once a second and `collect` a little later, `note` right before a SIGKILL, `died`
    after an exit by a signal or with a code other than 0, and `free` once a second and at the end.
    A reader of /proc/locks waits until every processor has been idle or switched once, 5 to 15 ms:
    `note` blocks for them, and `keep_up` lets a thread wait, only if files are new. `free` after a
    kill reads the mappings of every participant on the machine, each in 0.3 ms. Grandchildren and
    daemons are included, since they have the run id, too. So are helpers: our children without a
    run id, and `helper_pids` with their children. Call `release` when they have ended.
    """

    def __init__(self, run_id: str, *, folder: Folder = shared_memory.FOLDER) -> None:
        self._run_id = run_id
        self._folder = folder
        self.helper_pids: set[int] = set()
        self._ours: set[str] = set()
        self._ports: set[str] = set()  # that were ours at some time
        self._seen: dict[str, int] = {}
        self._files = shared_memory.lock_files(folder)
        self._unsettled_until_s = 0.0
        self._noted_s = 0.0
        self._read: bytes | None = None  # by the thread
        self.is_reading = False
        self._begun_s = time.time()
        self._lives_s: list[tuple[float, float]] = []  # wall time: start, death
        self._was_killed = self._are_ports_due = False

    @property
    def names(self) -> frozenset[str]:
        """Segments and ports of our processes that were recorded and not freed."""
        return frozenset(self._ours)

    def keep_up(self, now: float) -> None:
        """Begin to read if the lock files have changed; `now` is monotonic."""
        files = shared_memory.lock_files(self._folder)
        if files != self._files:
            self._files = files
            self._unsettled_until_s = now + shared_memory.SETTLING_S
        self._noted_s = self._noted_s or now
        has_news = now < self._unsettled_until_s or now > self._noted_s + STALE_NEWS_S
        if files and has_news and not self.is_reading:
            self._noted_s = now
            self.is_reading = True
            _thread.start_new_thread(self._read_locks, ())

    def _read_locks(self) -> None:
        self._read = proc.read(".", "locks")  # without the interpreter's lock, while it waits

    def collect(self) -> None:
        """Record what was read since `keep_up`; nothing as long as `is_reading`."""
        locks, self._read = self._read, None
        if locks is not None:
            self.is_reading = False
            self._record(locks)

    def note(self) -> None:
        """Record what is held now."""
        self._record(proc.read(".", "locks"))

    def _record(self, locks: bytes) -> None:
        """Record what is held, after reading the run id of new owners."""
        with contextlib.suppress(OSError):  # no /dev/shm: nothing to note
            now = shared_memory.holders(locks, self._folder)
            for name, pid in now.items():
                if self._seen.get(name) != pid and self._is_ours(pid):
                    self._ours.add(name)
            self._ports.update(filter(shared_memory.is_port, self._ours))
            self._seen = now

    def _is_ours(self, pid: int) -> bool:
        run_id = run_id_of(pid)
        if run_id is not None or pid in self.helper_pids:
            return run_id in (self._run_id, None)
        parent = int(proc.status_field(pid, "PPid") or 0)
        return parent == os.getpid() or parent in self.helper_pids

    def died(self, returncode: int, since_s: float) -> None:
        """A process has exited, and may have left files; its start began at this wall time.

        It may not have been recorded, so segments that were made meanwhile are looked at.
        """
        now = time.time()
        # The first processes were started a little before the ledger was made.
        since_s = max(since_s, self._begun_s - shared_memory.SETTLING_S)
        self._lives_s.append((since_s - CLOCK_TICK_S, now + CLOCK_TICK_S))
        if not 0 <= returncode <= 128:  # a shell adds the number of the signal to 128
            self._was_killed = self._are_ports_due = True

    def free(self, *, is_last: bool = False) -> int:
        """Free what processes that died have left, and return the bytes; the rest stays recorded.

        `is_last`: no process of the run is left. Ports are freed only after one was killed or has
        left a segment: others have removed their ports, and those that are there may be in use.
        """
        if not self._lives_s and not is_last:
            return 0
        spans_s, self._lives_s = self._lives_s, []
        self._ours |= shared_memory.ownerless(spans_s, folder=self._folder)
        ports = set(filter(shared_memory.is_port, self._ours))
        freed = shared_memory.free(self._ours - ports, folder=self._folder)
        if freed:
            self._was_killed = self._are_ports_due = True
        if self._are_ports_due or (is_last and self._was_killed):
            freed += shared_memory.free(ports, folder=self._folder)
        self._are_ports_due = False
        self._ours = shared_memory.present(self._ours, folder=self._folder)
        return freed

    def release(self) -> None:
        """Free all that the run has left: none of its processes, and no helper, is there any more.

        A helper may have been killed before anything of it was recorded, and a sender makes a port
        again: so what was made meanwhile, and nobody uses, is freed, whoever has made it.
        """
        self.collect()
        span_s = (self._begun_s - shared_memory.SETTLING_S, time.time() + CLOCK_TICK_S)
        self._lives_s.append(span_s)
        self.free(is_last=True)
        made = shared_memory.ports_from([span_s], folder=self._folder)
        shared_memory.free(made | self._ports, folder=self._folder)
