"""Finds and frees what Fast DDS leaves in /dev/shm when its process is killed.

What Fast DDS does (observed on 2.14 with real nodes):

* Each participant makes one segment `fastrtps_<16 hex>` and holds an exclusive flock on
  `fastrtps_<16 hex>_el` while it exists. The kernel releases the lock with the process; nothing
  removes the files of a killed one.
* A port `fastrtps_port<N>` belongs to its reader, who holds the lock on `..._el` (`..._sl` where
  readers share it). Writers only map it. The file may be left without its lock file, and
  `sem.fastrtps_port<N>_mutex` with it. That is a semaphore, held while a port is opened or removed.
  Ports from 7000 on are shared by the participants of all domains.

The lock is the only test that sees all processes: it works across users, pid and mount namespaces,
where /proc shows nothing. So nothing is freed whose lock is held or may not be tested; a port,
which writers use without a lock, is freed only if every live participant on this /dev/shm can be
looked at and none has it mapped. Names without a lock file that are no ports are left alone.
Standard library only.
"""

from __future__ import annotations

import _thread
import contextlib
import fcntl
import mmap
import os
import re
import time
from collections.abc import Iterable, Iterator

from launcher import proc
from launcher.engine.cleanup.run_id import run_id_of
from launcher.model.record import Record

TYPE_CHECKING = False
if TYPE_CHECKING:
    Folder = str | os.PathLike[str]

FOLDER = "/dev/shm"
# Fast DDS makes a lock file and locks it right after; in between it looks unused.
SETTLING_S = 2.0
CLOCK_TICK_S = 0.01  # times of files are those of the last tick of the kernel, so much too early
STALE_NEWS_S = 30.0  # a port may get another owner without a change in the folder

_SEGMENT_LOCK = r"(fast(?:rtps|dds)_[0-9a-f]{16})_el$"
_PORT_FILE = r"(?:sem\.)?(fast(?:rtps|dds)_port\d+)(?:_el|_sl|_mutex)?$"
_LOCK_FILE = r"fast(?:rtps|dds)_\w+_[es]l$"
_MAPPED = rb"/(fast(?:rtps|dds)_\w+)"
_SEMAPHORE_BYTES = 32  # sem_t
_LOCK_LINE = r"^\d+: FLOCK +\S+ +\S+ +(\d+) ([0-9a-f]+):([0-9a-f]+):(\d+) "


class Stale(Record):
    """A segment or a port that is not used any more.

    `name` is that of the shared memory itself; `size_bytes` is what its files take.
    """

    name: str
    size_bytes: int

    @property
    def is_port(self) -> bool:
        return _is_port(self.name)


def stale(*, folder: Folder = FOLDER, now_s: float | None = None) -> list[Stale]:
    """All that is not used, sorted by name; `now_s` is wall time, as the files' times are."""
    before_s = (time.time() if now_s is None else now_s) - SETTLING_S
    names = _names(folder)
    unused = _unmapped(_ports(names), folder, before_s)
    return [
        Stale(name, _size(folder, name))
        for name in sorted(_segments(names) | unused)
        if _is_settled(folder, name, before_s) and _is_free(folder, name)
    ]


def free(names: Iterable[str], *, folder: Folder = FOLDER) -> int:
    """Free those of these segments and ports that are not used; the bytes that were freed.

    What is in use, already gone or another user's is left, without an error.
    """
    wanted = set(names)
    ports = set(filter(_is_port, wanted))
    freed_bytes = sum(_free(folder, name) for name in wanted - ports)
    # Now, since a fresh segment of the dead is like that of a participant which is just starting.
    before_s = time.time() - SETTLING_S
    unused = {name for name in _unmapped(ports, folder, before_s) if _is_free(folder, name)}
    with contextlib.ExitStack() as stack:
        ours = {name for name in unused if _enter(stack, _mutex(folder, name))}
        # Again, since a participant may have opened one before its mutex was ours.
        return freed_bytes + sum(_free(folder, name) for name in _unmapped(ours, folder, before_s))


def held(*, folder: Folder = FOLDER) -> dict[str, int]:
    """Segment or port -> pid of the process that holds its lock, as far as /proc shows it.

    A lock from another pid namespace is not listed there. One read for all processes.
    """
    return _holders(proc.read(".", "locks"), folder)


def _holders(locks: bytes, folder: Folder) -> dict[str, int]:
    owners = _lock_owners(locks)
    device = os.stat(folder).st_dev
    files = _lock_files(folder).items()
    found = ((name[:-3], owners.get((device, inode))) for name, inode in files)
    return {name: pid for name, pid in found if pid}


class Ledger:
    """Shared memory of the processes of one run, recorded while they are running.

    Call `keep_up` once a second and `collect` a little later, `note` right before a SIGKILL, `died`
    after an exit by a signal or with a code other than 0, and `free` once a second and at the end.
    A reader of /proc/locks waits until every processor has been idle or switched once, 5 to 15 ms:
    `note` blocks for them, and `keep_up` lets a thread wait, only if files are new. `free` after a
    death reads the mappings of every participant on the machine, each in 0.3 ms. Grandchildren and
    daemons are included, since they have the run id, too. `helper_pids` count as processes of the
    run without its id.
    """

    def __init__(self, run_id: str, *, folder: Folder = FOLDER) -> None:
        self._run_id = run_id
        self._folder = folder
        self.helper_pids: set[int] = set()
        self._ours: set[str] = set()
        self._seen: dict[str, int] = {}
        self._files = _lock_files(folder)
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
        files = _lock_files(self._folder)
        if files != self._files:
            self._files = files
            self._unsettled_until_s = now + SETTLING_S
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
            now = _holders(locks, self._folder)
            for name, pid in now.items():
                if self._seen.get(name) != pid and self._is_ours(pid):
                    self._ours.add(name)
            self._seen = now

    def _is_ours(self, pid: int) -> bool:
        return pid in self.helper_pids or run_id_of(pid) == self._run_id

    def died(self, returncode: int, lived_s: float) -> None:
        """A process has exited, and may have left files; it had started `lived_s` ago.

        It may not have been recorded, so segments that were made meanwhile are looked at.
        """
        now = time.time()
        since_s = max(now - lived_s, self._begun_s - SETTLING_S)  # at most since the run began
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
        self._ours |= self._unrecorded()
        ports = set(filter(_is_port, self._ours))
        freed = free(self._ours - ports, folder=self._folder)
        if freed:
            self._was_killed = self._are_ports_due = True
        if self._are_ports_due or (is_last and self._was_killed):
            freed += free(ports, folder=self._folder)
        self._are_ports_due = False
        left = set(_names(self._folder))
        self._ours = {n for n in self._ours if n in left or f"{n}_el" in left}
        return freed

    def _unrecorded(self) -> set[str]:
        """Segments without an owner that were made while a process lived that has died since.

        Fast DDS makes the file of a segment when it has the lock, so if that is free, the owner has
        exited, however fresh the files are. A lock file alone may be about to be locked.
        """
        lives_s, self._lives_s = self._lives_s, []
        return {
            name
            for name in (_segments(_names(self._folder)) - self._ours if lives_s else ())
            if os.path.exists(f"{self._folder}/{name}")
            and _was_made_within(self._folder, name, lives_s)
            and _is_free(self._folder, name)
        }


# ---- files and owners


def _names(folder: Folder) -> list[str]:
    try:
        return os.listdir(folder)
    except OSError:
        return []


def _lock_files(folder: Folder) -> dict[str, int]:
    """Name -> inode of the lock files; none where there is no such folder."""
    try:
        with os.scandir(folder) as entries:
            return {e.name: e.inode() for e in entries if re.match(_LOCK_FILE, e.name)}
    except OSError:
        return {}


def _is_port(name: str) -> bool:
    return re.match(_PORT_FILE, name) is not None


def _segments(names: Iterable[str]) -> set[str]:
    return {match[1] for name in names if (match := re.match(_SEGMENT_LOCK, name))}


def _ports(names: Iterable[str]) -> set[str]:
    return {match[1] for name in names if (match := re.match(_PORT_FILE, name))}


def _files(name: str) -> tuple[str, ...]:
    """All files of this name, in the order of removal."""
    if _is_port(name):
        return (name, f"sem.{name}_mutex", f"{name}_sl", f"{name}_el")
    return (name, f"{name}_el")


def _size(folder: Folder, name: str) -> int:
    return sum(_blocks_bytes(f"{folder}/{file}") for file in _files(name))


def _blocks_bytes(path: str) -> int:
    try:
        return os.stat(path).st_blocks * 512
    except OSError:
        return 0


def _is_settled(folder: Folder, name: str, before_s: float) -> bool:
    """Whether none of its files was made after `before_s`."""
    for file in _files(name):
        with contextlib.suppress(OSError):
            if os.stat(f"{folder}/{file}").st_ctime > before_s:
                return False
    return True


def _was_made_within(folder: Folder, segment: str, spans_s: list[tuple[float, float]]) -> bool:
    """Whether its lock file was made in one of these times; nothing writes to it."""
    try:
        made_s = os.stat(f"{folder}/{segment}_el").st_ctime
    except OSError:
        return False
    return any(since_s <= made_s <= until_s for since_s, until_s in spans_s)


def _lock_owners(locks: bytes) -> dict[tuple[int, int], int]:
    """(device, inode) -> pid for every flock in the contents of /proc/locks."""
    text = locks.decode("ascii")
    return {
        (os.makedev(int(major, 16), int(minor, 16)), int(inode)): int(pid)
        for pid, major, minor, inode in re.findall(_LOCK_LINE, text, re.M)
    }


def _unmapped(ports: set[str], folder: Folder, before_s: float) -> set[str]:
    """Those of the ports that no running participant has mapped.

    Empty if there is a participant whose mappings cannot be read. Every participant holds the lock
    of a segment, so none is missed; one that may be just starting counts as unreadable.
    """
    if not ports:
        return set()
    owners = held(folder=folder)
    mapped: set[str] = set()
    for segment in _segments(_names(folder)):
        owner = owners.get(segment)
        if owner is None and _is_settled(folder, segment, before_s) and _is_free(folder, segment):
            continue
        names = _mapped_by(owner)
        if names is None:
            return set()
        mapped |= names
    return ports - mapped


def _mapped_by(pid: int | None) -> set[str] | None:
    """Segments and ports of Fast DDS that the process has mapped; None if that is unknown."""
    if pid is None:
        return None
    names = {name.decode("ascii") for name in re.findall(_MAPPED, proc.read(pid, "maps"))}
    return names or None  # an owner maps its own segment, so another process has this pid


# ---- locking


def _enter(stack: contextlib.ExitStack, lock: contextlib.AbstractContextManager[None]) -> bool:
    try:
        stack.enter_context(lock)
    except OSError:
        return False  # held, or not ours to take
    return True


def _semaphore_memory(fd: int) -> mmap.mmap:
    """The memory of a semaphore; OSError if the file is too short. Closes the descriptor."""
    try:
        return mmap.mmap(fd, _SEMAPHORE_BYTES)
    except ValueError as error:
        raise OSError(*error.args) from error
    finally:
        os.close(fd)


@contextlib.contextmanager
def _mutex(folder: Folder, port: str) -> Iterator[None]:
    """Hold the semaphore under which Fast DDS opens a port, if there is one; OSError.

    A participant that opens a port maps its file first, and locks it later. If the file is removed
    in between, the participant reads what nobody writes to, and discovers no other ever.
    """
    try:
        fd = os.open(f"{folder}/sem.{port}_mutex", os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    except FileNotFoundError:
        yield
        return
    import ctypes  # only runs whose processes were killed need it

    libc = ctypes.CDLL(None)
    with _semaphore_memory(fd) as memory:
        semaphore = (ctypes.c_char * _SEMAPHORE_BYTES).from_buffer(memory)
        try:
            if libc.sem_trywait(semaphore) != 0:
                raise BlockingIOError("somebody opens this port")
            try:
                yield
            finally:
                libc.sem_post(semaphore)
        finally:
            del semaphore  # the memory cannot be unmapped before


def _is_free(folder: Folder, name: str) -> bool:
    with contextlib.ExitStack() as stack:
        return _take(stack, folder, name)


def _free(folder: Folder, name: str) -> int:
    """Remove all files of this name while its locks are ours; the bytes, 0 if it is in use."""
    freed = 0
    with contextlib.ExitStack() as stack:
        if not _take(stack, folder, name):
            return 0
        for file in _files(name):
            size_bytes = _blocks_bytes(f"{folder}/{file}")
            with contextlib.suppress(OSError):  # not there, or not ours to delete
                os.unlink(f"{folder}/{file}")
                freed += size_bytes
    return freed


def _take(stack: contextlib.ExitStack, folder: Folder, name: str) -> bool:
    """Take the locks of `name` until the stack is closed; False if one is held.

    A segment must have its lock file; a port may have lost it.
    """
    is_port = _is_port(name)
    for suffix in ("_el", "_sl") if is_port else ("_el",):
        try:
            stack.enter_context(_locked(f"{folder}/{name}{suffix}"))
        except FileNotFoundError:
            if not is_port:
                return False
        except OSError:
            return False  # held, or not ours to test
    return True


@contextlib.contextmanager
def _locked(path: str) -> Iterator[None]:
    """Hold an exclusive lock; BlockingIOError if it is held, FileNotFoundError, PermissionError."""
    fd = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.fstat(fd).st_ino != os.stat(path).st_ino:
            raise BlockingIOError("this file was made again")
        yield
    finally:
        os.close(fd)
