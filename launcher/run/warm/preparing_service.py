"""Serves the requests of the launcher, in the preparing process.

The first request says which programs to prepare for; the answers to it are `{"step": name}` as a
sign of life, and `{"ready": ...}`. Each further one with `start` is a start: its descriptors are
stdin, stdout, stderr and `status`, a socket; the answer is `{"start": number, "pid": pid}`. The new
process waits on `status` for a byte, or ends with its peer, and closes it when its program begins;
or it writes to it what was refused (`limits.parse_refusal`). `{"stale": name}` says that what was
imported has changed on disk. An empty request announces a start, for which a process is forked
ahead; the answer is `{"spare": pid}`.
"""

from __future__ import annotations

import _socket
import ctypes
import gc
import os
import sys

from launcher.base import strict_json
from launcher.base.text import typed_error
from launcher.posix import proc
from launcher.run.warm import preparing_messages
from launcher.run.warm.child import become
from launcher.run.warm.forking import Forker
from launcher.run.warm.preparation import Preparation, Scan, is_lazy
from launcher.run.warm.spare import Spare

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Any

    Stamp = tuple[int, int, int]


def serve(number: int) -> Callable[[], object]:
    """Serve the socket with this number; returns in forked processes only."""
    os.set_inheritable(number, False)
    socket = _socket.socket(fileno=number)
    order = _order(socket)
    scan = Scan(order["programs"])
    _forget_ours()
    gc.disable()  # nothing of what is imported is garbage
    preparation = _prepare(socket, order, scan)
    stamps = Stamps.of_what_is_loaded()
    fill_gaps()
    gc.freeze()
    gc.enable()
    preparing_messages.send_answer(socket, {"ready": preparation.result()})
    return _serve_starts(socket, Forker(preparation.tracing), stamps, preparation.added)


def _prepare(socket: _socket.socket, order: Any, scan: Scan) -> Preparation:
    def step(name: str) -> None:
        preparing_messages.send_answer(socket, {"step": name})

    try:
        preparation = Preparation(order, scan, step)
        without = preparation.run()
        if without:
            _begin_again(socket, {**order, "without": without})
    except Exception as error:
        preparing_messages.send_answer(socket, {"failed": typed_error(error)[:1000]})
        os._exit(1)
    return preparation


def _order(socket: _socket.socket) -> Any:
    """What to prepare: from the launcher, or from the process that we have been before."""
    if len(sys.argv) > 2:
        with open(int(sys.argv[2]), encoding="utf-8") as file:
            file.seek(0)
            return strict_json.unpacked(file.read())
    request = preparing_messages.receive_request(socket)
    if request is None:
        os._exit(0)
    return request[0]


def _begin_again(socket: _socket.socket, order: Any) -> None:
    """Become a new preparing process, which leaves out more modules."""
    file = os.memfd_create("launcher-order", 0)
    os.write(file, strict_json.packed(order).encode())
    os.set_inheritable(socket.fileno(), True)
    words = [*sys.orig_argv[:2], str(socket.fileno()), str(file)]
    os.execve(sys.executable, words, order["environment"])


def _serve_starts(
    socket: _socket.socket, forker: Forker, stamps: Stamps, added: dict[str, str]
) -> Callable[[], object]:
    spare: Spare | None = None
    while True:
        request = preparing_messages.receive_request(socket)
        if request is None:
            os._exit(0)
        content, fds = request
        if not content:
            spare = spare or Spare(forker)
            if spare.pid == 0:
                socket.close()
                return become(*spare.wait(), added, forker.restore_threads)
            preparing_messages.send_answer(socket, {"spare": spare.pid})
            continue
        changed = stamps.first_change()
        if changed is not None:
            preparing_messages.send_answer(socket, {"stale": changed})
            os._exit(0)
        pid = spare.pid if spare is not None and spare.give(content, fds) else forker.fork()
        if pid == 0:
            socket.close()
            return become(content, fds, added, forker.restore_threads)
        spare = None
        for fd in fds:
            os.close(fd)
        preparing_messages.send_answer(socket, {"start": content["start"], "pid": pid})


def _forget_ours() -> None:
    """A program that imports modules with our names gets its own."""
    for name in list(sys.modules):
        if name.partition(".")[0] == "launcher":
            del sys.modules[name]


class Stamps:
    """Whether what was imported is still what is on disk.

    Of each file its time in nanoseconds, size and inode; of a folder its time.
    """

    def __init__(self, stamps: dict[str, Stamp]) -> None:
        self._stamps = stamps

    @classmethod
    def of_what_is_loaded(cls) -> Stamps:
        """Of all modules and shared libraries, and of the folders with installed packages.

        pip creates or removes an entry there with every change.
        """
        paths = {*_modules(), *_libraries(), *_folders()}
        return cls({path: stamp for path in paths if (stamp := _stamp(path)) is not None})

    def first_change(self) -> str | None:
        """A path that has changed; None if there is none. A thousand take 2 ms."""
        return next((path for path, then in self._stamps.items() if _stamp(path) != then), None)


def _stamp(path: str) -> Stamp | None:
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def _modules() -> Iterator[str]:
    for module in list(sys.modules.values()):
        file = None if is_lazy(module) else getattr(module, "__file__", None)
        if isinstance(file, str):
            yield file


def _libraries() -> Iterator[str]:
    for path in proc.mapped(os.getpid()):
        if path.startswith("/") and not path.startswith(("/dev/", "/memfd:")):
            yield path


def _folders() -> Iterator[str]:
    """Not all of `sys.path`: a source folder changes whenever a file in it is saved."""
    names = ("site-packages", "dist-packages")
    return (path for path in sys.path if os.path.basename(path) in names and os.path.isdir(path))


# ---- the C heap

# Bytes. Large gaps are taken in few pieces, since each piece writes to one page; malloc of glibc
# rounds small sizes up to multiples of 16.
_SIZES = (65536, 32768, 16384, 8192, *range(4096, 0, -16))


def fill_gaps() -> None:
    """Keep pages of the C heap shared between this process and those that it forks.

    Imports leave gaps all over the heap. A forked process that allocates in one writes to its page,
    and so gets a copy of the page. With the gaps taken before the fork, and never freed, it
    allocates in few new pages instead: 1 MB less per node. Without effect where the C library is
    not glibc.
    """
    libc = ctypes.CDLL(None)
    if not hasattr(libc, "malloc_trim"):
        return
    libc.malloc.restype = libc.sbrk.restype = ctypes.c_void_p
    libc.malloc.argtypes = [ctypes.c_size_t]
    libc.sbrk.argtypes = [ctypes.c_ssize_t]
    libc.free.argtypes = [ctypes.c_void_p]
    libc.malloc_trim(0)  # the heap ends with its last allocation, and pages of gaps are released
    end = libc.sbrk(0)  # other allocators and mappings are above it
    for size in _SIZES:
        while (address := libc.malloc(size)) and address < end:
            pass
        libc.free(address)
