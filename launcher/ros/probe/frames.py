"""The tree of frames (`tf tree`), received while somebody asks for it."""

from __future__ import annotations

import time
from typing import Any

from launcher.ros.discovery.observer import Observer
from launcher.ros.tf.frame_tree import FrameTree
from launcher.ros.tf.tf_listener import TfListener, require_type
from launcher.ros.tf.tf_message import TOPICS

_UNASKED_S = 20.0  # after it, nothing is received
_WINDOW_S = 10.0  # of what is known of moving frames


class ProbeFrames:
    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self._listener: TfListener | None = None
        self._tree = FrameTree()
        self._asked_s = self._window_s = 0.0

    def answer(self) -> dict[str, Any]:
        """What has arrived so far; VerbError without the type of the messages."""
        self._asked_s = time.monotonic()
        if self._listener is None:
            require_type()
            self._listener = TfListener(self._observer, TOPICS, 0.0)
            self._tree, self._window_s = FrameTree(), self._asked_s
        passes = iter((True, False))  # the first may subscribe to a new publisher
        for sample in self._listener.samples(lambda: next(passes)):
            self._tree.take(sample)
        now_ns = time.time_ns()
        rows, problems = self._tree.rows(now_ns), self._tree.problems(now_ns)
        if self._asked_s - self._window_s > _WINDOW_S:
            self._tree.forget(now_ns - round(_WINDOW_S * 1e9))
            self._window_s = self._asked_s
        return {"rows": rows, "problems": [problem.text for problem in problems]}

    def rest(self) -> None:
        """Receive no more if nobody asks."""
        if self._listener is not None and time.monotonic() - self._asked_s > _UNASKED_S:
            self._listener.close()
            self._listener = None
