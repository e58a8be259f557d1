"""A long-lived POSIX shell on a host, which is given scripts and answers each.

Scripts come through its standard input, so that nothing of them is in a command line there. A
script runs in a subshell, one after the other. Once a second the shell's own loop says that it is
alive, also while a script is running.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable

from launcher.base.model.record import Record

OnAnswer = Callable[["ScriptResult"], None]


_HEART = re.compile(rb"\x01H ([0-9.]+)\x02")
_ANSWER = re.compile(rb"\x01A (\d+) (\d+) ([^\x02]*)\x02", re.DOTALL)
# The loop ends with the shell, also if that is killed: nobody reads its output any more. Signals
# that stop the whole session end it, too.
START = r"""
launcher_beat() {
  while read -r up _ </proc/uptime && printf '\001H %s\002' "$up" 2>/dev/null; do
    sleep 1
    [ -d "/proc/$$" ] || exit
  done
}
launcher_beat </dev/null &
"""


class ScriptResult(Record):
    """The exit code of a script, and what it has written to both streams."""

    code: int
    text: str


class ScriptRequest(Record):
    """A script, which does no harm if it is run twice, and what gets its answer.

    `on_loss` is called if it does not last, and the link was lost before the answer.
    """

    script: str
    on_answer: OnAnswer | None = None
    lasts: bool = True  # whether it is of use after the link was lost
    on_loss: Callable[[], None] | None = None


class Answers:
    """Frames scripts, splits what the shell writes into answers and heart beats, and calls back.

    `on_beat` gets the seconds since the host was started.
    """

    def __init__(self, on_beat: Callable[[float], None]) -> None:
        self._on_beat = on_beat
        self._buffer = b""
        self._number = 0
        self._waiting: deque[tuple[int, ScriptRequest]] = deque()

    def framed(self, request: ScriptRequest) -> bytes:
        """What the shell reads for this request."""
        self._number += 1
        self._waiting.append((self._number, request))
        return (
            f"launcher_out=$( {{ {request.script}\n}} </dev/null 2>&1 ); "
            f'printf \'\\001A {self._number} %d %s\\002\' "$?" "$launcher_out"\n'
        ).encode("utf-8", "surrogateescape")

    @property
    def unanswered(self) -> list[ScriptRequest]:
        """In the order of `framed`."""
        return [request for _, request in self._waiting]

    def feed(self, data: bytes) -> None:
        self._buffer += data
        for beat in _HEART.findall(self._buffer):
            self._on_beat(float(beat))
        self._buffer = _HEART.sub(b"", self._buffer)
        while found := _ANSWER.search(self._buffer):
            self._buffer = self._buffer[found.end() :]
            self._answered(
                int(found[1]), ScriptResult(int(found[2]), found[3].decode(errors="replace"))
            )
        if b"\x01" not in self._buffer:
            self._buffer = b""  # what a login shell prints

    def _answered(self, number: int, answer: ScriptResult) -> None:
        while self._waiting and self._waiting[0][0] <= number:
            got, request = self._waiting.popleft()
            if got == number and request.on_answer is not None:
                request.on_answer(answer)
