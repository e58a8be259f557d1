"""Serves the requests of the launcher, in the preparing process.

The first request says which programs to prepare for; the answers to it are `{"step": name}` as a
sign of life, and `{"ready": ...}`. Each further one is a start: its descriptors are stdin, stdout,
stderr and `status`, a socket; the answer is `{"start": number, "pid": pid}`. The new process waits
on `status` for a byte, or ends with its peer, and closes it when its program begins; or it writes
to it what was refused (`limits.parse_refusal`). `{"stale": name}` says that what was imported has
changed on disk.
"""

from __future__ import annotations

import _socket
import gc
import os
import sys

from launcher.base import strict_json
from launcher.base.text import typed_error
from launcher.run.warm import wire
from launcher.run.warm.child import become
from launcher.run.warm.forking import Forker
from launcher.run.warm.freshness import Stamps
from launcher.run.warm.heap import fill_gaps
from launcher.run.warm.preparation import Preparation
from launcher.run.warm.scan import Scan

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any


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
    wire.send_answer(socket, {"ready": preparation.result()})
    return _serve_starts(socket, Forker(preparation.tracing), stamps, preparation.added)


def _prepare(socket: _socket.socket, order: Any, scan: Scan) -> Preparation:
    try:
        step = lambda name: wire.send_answer(socket, {"step": name})  # noqa: E731
        preparation = Preparation(order, scan, step)
        without = preparation.run()
        if without:
            _begin_again(socket, {**order, "without": without})
    except Exception as error:
        wire.send_answer(socket, {"failed": typed_error(error)[:1000]})
        os._exit(1)
    return preparation


def _order(socket: _socket.socket) -> Any:
    """What to prepare: from the launcher, or from the process that we have been before."""
    if len(sys.argv) > 2:
        with open(int(sys.argv[2]), encoding="utf-8") as file:
            file.seek(0)
            return strict_json.unpacked(file.read())
    request = wire.receive_request(socket)
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
    while True:
        request = wire.receive_request(socket)
        if request is None:
            os._exit(0)
        content, fds = request
        changed = stamps.first_change()
        if changed is not None:
            wire.send_answer(socket, {"stale": changed})
            os._exit(0)
        pid = forker.fork()
        if pid == 0:
            socket.close()
            return become(content, fds, added, forker.restore_threads)
        for fd in fds:
            os.close(fd)
        wire.send_answer(socket, {"start": content["start"], "pid": pid})


def _forget_ours() -> None:
    """A program that imports modules with our names gets its own."""
    for name in list(sys.modules):
        if name.partition(".")[0] == "launcher":
            del sys.modules[name]
