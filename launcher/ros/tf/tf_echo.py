"""`tf echo`: one transform again and again, as tf2_echo prints it."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Any

from launcher.posix.json_output import print_line
from launcher.ros.tf.arithmetic import matrix, roll_pitch_yaw
from launcher.ros.tf.frame_buffer import StampedTransform, TfError, TransformBuffer

WAITING_S = 1.0  # between two lines about what is not there


@dataclass(frozen=True, slots=True, kw_only=True)
class TfEchoOptions:
    """`frame` is tf2_echo's source_frame, into which data of `other` are brought.

    `time_ns` 0 is the latest time.
    """

    frame: str
    other: str
    period_s: float
    time_ns: int
    digits: int
    json: bool


class TfEcho:
    """Prints when it is due; `printed` counts transforms."""

    def __init__(self, buffer: TransformBuffer, options: TfEchoOptions) -> None:
        self.printed = 0
        self._buffer = buffer
        self._options = options
        self._is_there = False
        self._due_s = -math.inf

    def step(self, now_ns: int, elapsed_s: float, *, waits: bool = True) -> None:
        """Print what is due. Until the first transform is there, say why not, if it `waits`."""
        if not self._is_there:
            if self._due_s == -math.inf:
                self._due_s = elapsed_s + WAITING_S
            options = self._options
            why = self._buffer.why_not(options.frame, options.other, options.time_ns)
            if why is not None:
                if waits and elapsed_s >= self._due_s:
                    self._due_s = elapsed_s + WAITING_S
                    line = waiting("tf2_echo", options.frame, options.other, why, now_ns)
                    print(line, file=sys.stderr, flush=True)
                return
            self._is_there, self._due_s = True, elapsed_s
        if elapsed_s >= self._due_s:
            self._due_s = max(self._due_s + self._options.period_s, elapsed_s)
            self.show(now_ns)

    def show(self, now_ns: int) -> None:
        options = self._options
        try:
            found = self._buffer.lookup(options.frame, options.other, options.time_ns)
        except TfError as error:
            self._fail(str(error), now_ns)
            return
        self.printed += 1
        if options.json:
            print_line(document(found))
        else:
            print("\n".join(text_lines(found, options.digits)), flush=True)

    def _fail(self, text: str, now_ns: int) -> None:
        if self._options.json:
            print_line({"time_ns": now_ns, "failure": text})
            return
        print(f"Failure at {now_ns / 1e9:.{self._options.digits}f}\nException thrown:{text}")
        print(f"The current list of frames is:\n{self._buffer.frames_text()}", flush=True)


def waiting(logger: str, frame: str, other: str, why: str, now_ns: int) -> str:
    """The line as the logger of ROS 2 prints it."""
    stamp = f"{now_ns // 10**9}.{now_ns % 10**9:09}"
    return f"[INFO] [{stamp}] [{logger}]: Waiting for transform {frame} ->  {other}: {why}"


def text_lines(found: StampedTransform, digits: int) -> list[str]:
    translation, rotation = found.transform
    radians = roll_pitch_yaw(rotation)

    def listed(numbers: tuple[float, ...]) -> str:
        return f"[{', '.join(f'{number:.{digits}f}' for number in numbers)}]"

    rows = [(*row, end) for row, end in zip(matrix(rotation), translation, strict=True)]
    return [
        # unlike tf2_echo's, the nanoseconds have all of their zeros
        f"At time {found.stamp_ns // 10**9}.{found.stamp_ns % 10**9:09}",
        f"- Translation: {listed(translation)}",
        f"- Rotation: in Quaternion (xyzw) {listed(rotation)}",
        f"- Rotation: in RPY (radian) {listed(radians)}",
        f"- Rotation: in RPY (degree) {listed(tuple(map(math.degrees, radians)))}",
        "- Matrix:",
        *(
            "".join(f" {number:6.{digits}f}" for number in row)
            for row in (*rows, (0.0, 0.0, 0.0, 1.0))
        ),
    ]


def document(found: StampedTransform) -> dict[str, Any]:
    translation, rotation = found.transform
    return {
        "time_ns": found.stamp_ns,
        "frame": found.parent,
        "child": found.child,
        "translation": list(translation),
        "rotation": list(rotation),
        "rpy": list(roll_pitch_yaw(rotation)),
    }
