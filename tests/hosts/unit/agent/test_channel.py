"""Two ends of a connection."""

from __future__ import annotations

import os
import socket

from launcher.hosts.engine.frame_channel import WRITE_BYTES, FrameChannel
from launcher.hosts.engine.frames import OUTPUT_HEADER, Decoder, Frame, FrameKind
from launcher.posix.reactor import Reactor

FRAMES = 3000  # more than writev(2) takes at once
LARGE = 10_000  # bytes that are not copied behind their header


class End:
    """Collects what its channel receives, and stops the reactor at the last frame."""

    def __init__(self, reactor: Reactor, frames: int) -> None:
        self._reactor = reactor
        self._frames = frames
        self.channel = FrameChannel(reactor, self)
        self.payloads: list[bytes] = []
        self.lost_because: list[str] = []

    def received(self, frame: Frame) -> None:
        if frame.kind == FrameKind.OUTPUT:
            self.payloads.append(frame.payload + frame.rest)
        if len(self.payloads) == self._frames:
            self._reactor.stop()

    def lost(self, reason: str) -> None:
        self.lost_because.append(reason)
        self._reactor.stop()

    malformed = lost

    def relieved(self) -> None:
        pass


def test_many_small_frames_that_were_kept_arrive_after_a_return():
    payloads = [b"%d" % number for number in range(FRAMES)]
    assert sum(map(len, payloads)) < WRITE_BYTES
    with Reactor() as reactor:
        sender, receiver = End(reactor, FRAMES), End(reactor, FRAMES)
        for payload in payloads:
            sender.channel.send(FrameKind.OUTPUT, payload)
        there, back = os.pipe(), os.pipe()
        sender.channel.attach(back[0], there[1])
        receiver.channel.attach(there[0], back[1])
        sender.channel.resume(0)
        reactor.call_later(60.0, reactor.stop)
        reactor.run()
        assert receiver.payloads == payloads
        assert sender.lost_because == receiver.lost_because == []
        sender.channel.detach()
        receiver.channel.detach()


def test_output_of_one_turn_is_one_write():
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with Reactor() as reactor, theirs:
        sender = End(reactor, 0)
        fd = ours.detach()
        sender.channel.attach(os.dup(fd), fd)
        sender.channel.resume(0)
        for process_id in range(3):
            sender.channel.send_output(OUTPUT_HEADER.pack(process_id, 0), b"x" * LARGE)
        reactor.call_later(0, reactor.stop)
        reactor.run()
        frames = list(Decoder().feed(theirs.recv(4 * LARGE)))
        sender.channel.detach()

    assert [frame.data() for frame in frames] == [(n, 0, b"x" * LARGE) for n in range(3)]
