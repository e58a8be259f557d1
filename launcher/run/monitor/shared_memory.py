"""Finds and frees what Fast DDS leaves in /dev/shm when its process is killed.

What Fast DDS does (observed on 2.14 with real nodes):

* Each participant makes one segment `fastrtps_<16 hex>` and holds an exclusive flock on
  `fastrtps_<16 hex>_el` while it exists. The kernel releases the lock with the process; nothing
  removes the files of a killed one.
* A port `fastrtps_port<N>` belongs to its reader, who holds the lock on `..._el` (`..._sl` where
  readers share it). Writers only map it. The file may be left without its lock file, and
  `sem.fastrtps_port<N>_mutex` with it. That is a semaphore, held while a port is opened or removed.
  Ports from 7000 on are shared by the participants of all domains.
* A port counts who has opened it, and who closes it last removes it. One that was killed counts for
  ever. A sender to a participant that has just exited makes its port again.

The lock is the only test that sees all processes: it works across users, pid and mount namespaces,
where /proc shows nothing. So nothing is freed whose lock is held or may not be tested; a port,
which writers use without a lock, is freed only if every live participant on this /dev/shm can be
looked at and none has it mapped. Names without a lock file that are no ports are left alone.
Standard library only.
"""

from __future__ import annotations

import contextlib
import fcntl
import mmap
import os
import re
import time
from collections.abc import Collection, Iterable, Iterator

from launcher.base.model.record import Record
from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    Folder = str | os.PathLike[str]

FOLDER = "/dev/shm"
# Fast DDS makes a lock file and locks it right after; in between it looks unused.
SETTLING_S = 2.0

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
        return is_port(self.name)


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


def settled(*, folder: Folder = FOLDER) -> list[Stale]:
    """As `stale`, but of what looks unused, and is too young to know, it waits for the answer.

    Blocks for SETTLING_S if there is such.
    """
    found = stale(folder=folder)
    if len(stale(folder=folder, now_s=time.time() + SETTLING_S)) == len(found):
        return found
    time.sleep(SETTLING_S)
    return stale(folder=folder)


def free(names: Iterable[str], *, folder: Folder = FOLDER) -> int:
    """Free those of these segments and ports that are not used; the bytes that were freed.

    What is in use, already gone or another user's is left, without an error.
    """
    wanted = set(names)
    ports = set(filter(is_port, wanted))
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
    return holders(proc.read(".", "locks"), folder)


def ownerless(spans_s: Collection[tuple[float, float]], *, folder: Folder = FOLDER) -> set[str]:
    """Segments that were made in one of these spans of wall time, and whose owner has exited.

    Fast DDS makes the file of a segment when it has the lock, so if that is free, the owner has
    exited, however fresh the files are. A lock file alone may be about to be locked.
    """
    return {
        name
        for name in (_segments(_names(folder)) if spans_s else ())
        if os.path.exists(f"{folder}/{name}")
        and _is_from(spans_s, f"{folder}/{name}_el")
        and _is_free(folder, name)
    }


def present(names: Iterable[str], *, folder: Folder = FOLDER) -> set[str]:
    """Those of these segments and ports that have a file or a lock file."""
    there = set(_names(folder))
    return {name for name in names if name in there or f"{name}_el" in there}


def holders(locks: bytes, folder: Folder) -> dict[str, int]:
    """As `held`, from the contents of /proc/locks."""
    owners = _lock_owners(locks)
    device = os.stat(folder).st_dev
    files = lock_files(folder).items()
    found = ((name[:-3], owners.get((device, inode))) for name, inode in files)
    return {name: pid for name, pid in found if pid}


def lock_files(folder: Folder) -> dict[str, int]:
    """Name -> inode of the lock files; none where there is no such folder."""
    try:
        with os.scandir(folder) as entries:
            return {e.name: e.inode() for e in entries if re.match(_LOCK_FILE, e.name)}
    except OSError:
        return {}


def ports_from(spans_s: Collection[tuple[float, float]], *, folder: Folder = FOLDER) -> set[str]:
    """Ports of which a file was made in one of these spans of wall time, used or not."""
    return {
        port
        for port in _ports(_names(folder))
        if any(_is_from(spans_s, f"{folder}/{file}") for file in _files(port))
    }


def is_port(name: str) -> bool:
    """Whether a segment or port of this name is a port."""
    return re.match(_PORT_FILE, name) is not None


# ---- files and owners


def _names(folder: Folder) -> list[str]:
    try:
        return os.listdir(folder)
    except OSError:
        return []


def _segments(names: Iterable[str]) -> set[str]:
    return {match[1] for name in names if (match := re.match(_SEGMENT_LOCK, name))}


def _ports(names: Iterable[str]) -> set[str]:
    return {match[1] for name in names if (match := re.match(_PORT_FILE, name))}


def _files(name: str) -> tuple[str, ...]:
    """All files of this name, in the order of removal."""
    if is_port(name):
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


def _is_from(spans_s: Collection[tuple[float, float]], path: str) -> bool:
    """Whether a file was made in one of these spans; its status is not changed later."""
    try:
        made_s = os.stat(path).st_ctime
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
    names = {name.decode("ascii") for name in re.findall(_MAPPED, proc.read_memory(pid, "maps"))}
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
    is_a_port = is_port(name)
    for suffix in ("_el", "_sl") if is_a_port else ("_el",):
        try:
            stack.enter_context(_locked(f"{folder}/{name}{suffix}"))
        except FileNotFoundError:
            if not is_a_port:
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
