"""Records topics of a run into a bag, by `bag record` in a separate process."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from launcher.smoke.expect.likeness import traits_of_bag
from launcher.smoke.run.launcher_process import LauncherProcess

if TYPE_CHECKING:
    from launcher.bag.comparing.topic_traits import Traits

FOLDER, LOG = "recording", "recording.log"
SNAPSHOT = "snapshot"  # the folder of what the flight recorder had at the end
READY_S = 20.0  # importing rclpy on a busy machine
STOP_S = 20.0  # writing what is in memory
POLL_S = 0.02
_BEGUN = "recording into"  # what `bag record` prints once it looks for topics


class RecordingError(Exception):
    """The recording failed; the text is the last line of the recorder."""


class Recording:
    """A bag of these topics in `folder`; it begins with `wait_until_ready`."""

    def __init__(self, topics: Sequence[str], environment: Mapping[str, str], folder: Path) -> None:
        self._topics = tuple(topics)
        self._bag = folder / FOLDER
        options = ["--disable-keyboard-controls", "-o", str(self._bag)]
        self._process = LauncherProcess(
            ["bag", "record", *options, "--topics", *self._topics], environment, folder / LOG
        )

    def wait_until_ready(self) -> None:
        """RecordingError."""
        deadline_s = time.monotonic() + READY_S
        while not any(_BEGUN in line for line in self._process.last_lines(5)):
            if not self._process.is_alive or time.monotonic() > deadline_s:
                raise RecordingError(self._why("the recorder did not start"))
            time.sleep(POLL_S)

    def close(self, grace_s: float = STOP_S) -> None:
        """End it; may be called more than once."""
        self._process.stop(grace_s)

    def traits(self) -> dict[str, Traits]:
        """What it has, after `close`; RecordingError."""
        from launcher.bag.bag_model import BagError
        from launcher.bag.reader import Bag

        if self._process.returncode != 0:
            raise RecordingError(self._why("the recorder failed"))
        try:
            return traits_of_bag(Bag(str(self._bag)), self._topics)
        except BagError as error:
            raise RecordingError(error.message) from None

    def _why(self, text: str) -> str:
        lines = [line for line in self._process.last_lines(5) if line.strip()]
        return f"{text}: {lines[-1] if lines else 'no output'}"
