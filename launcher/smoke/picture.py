"""Picture: the ROS graph of a run as `graph.json` and `graph.svg`.

What was there is noted while the system runs, and drawn when it is over: drawing takes seconds.
`python -m launcher.smoke.picture JSON SVG` draws, so that a graph that takes too long can be left.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from launcher.domain_lease import busy_domains
from launcher.ros.errors import VerbError
from launcher.ros.snapshot.diff import load, to_document
from launcher.ros.snapshot.graph import TopicGraph
from launcher.smoke.outputs import save
from launcher.smoke.system import System

# Limits for a busy machine and a graph of many nodes; a second or two as a rule.
LOOK_S = 20.0
DRAW_S = 60.0
_LOOK = ("graph", "--json", "--debug-topics", "--hidden")


class Picture:
    """The graph of a system, with its probe's eyes or, without one, by a look of its own."""

    def __init__(self, system: System, folder: Path, *, is_wanted: bool) -> None:
        self._system = system
        self._json = folder / "graph.json"
        self._svg = folder / "graph.svg"
        self._is_wanted = is_wanted or system.probe is not None
        self._look: subprocess.Popen[bytes] | None = None

    def begin(self) -> None:
        """Look, if nobody does; the system goes on meanwhile. More than once does no harm."""
        if not self._is_wanted or self._look is not None or self._system.probe is not None:
            return
        if self._system.is_alive and self._system.domain_id in busy_domains():
            with self._json.open("wb") as file:
                self._look = subprocess.Popen(
                    [sys.executable, "-m", "launcher", *_LOOK],
                    stdin=subprocess.DEVNULL,
                    stdout=file,
                    stderr=subprocess.DEVNULL,
                    env=self._system.environment,
                    start_new_session=True,
                )

    def finish_look(self, within_s: float = LOOK_S) -> None:
        """What is seen is seen; the system may go."""
        if self._look is None:
            return
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._look.wait(within_s)
        if self._look.poll() is None:
            self._look.kill()
            self._look.wait()

    def draw(self) -> str | None:
        """Write the files; a sentence on why there is none, or not both of them."""
        if not self._is_wanted:
            return None
        snapshot = self._snapshot()
        if snapshot is None:
            self._json.unlink(missing_ok=True)
            return f"no picture of the ROS graph: {self._why()}"
        text = json.dumps(to_document(snapshot), indent=2, ensure_ascii=False)
        try:
            save(self._json, f"{text}\n")
        except OSError as error:
            return f"no picture of the ROS graph: {error.strerror}"
        return self._draw_svg()

    def _snapshot(self) -> TopicGraph | None:
        """The last graph with anybody in it, before the stop if there are some."""
        if self._look is not None:
            with contextlib.suppress(VerbError):
                return load(str(self._json))
            return None
        return next(self._seen(), None)

    def _seen(self) -> Iterator[TopicGraph]:
        facts = self._system.facts()
        for seen in reversed(facts.graphs):
            alive = set(seen.snapshot.nodes) - set(seen.snapshot.ghosts)
            if alive and seen.at_s <= facts.stop_s:
                yield seen.snapshot

    def _why(self) -> str:
        if self._look is not None:
            return "it could not be looked at in time"
        facts = self._system.facts()
        if self._system.probe is None and any(facts.node_names.values()):
            return "the system ended before anybody looked at it"
        return "no ROS node was seen"

    def _draw_svg(self) -> str | None:
        command = [sys.executable, "-m", "launcher.smoke.picture", str(self._json), str(self._svg)]
        try:
            done = subprocess.run(
                command,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=DRAW_S,
                check=False,
                start_new_session=True,
            )
        except subprocess.TimeoutExpired:
            return f"no drawing of the ROS graph: it takes more than {DRAW_S:g} s"
        if done.returncode:
            reason = (done.stderr.strip().splitlines() or ["no reason was given"])[-1]
            return f"no drawing of the ROS graph: {reason}"
        return None


def main(source: str, target: str) -> str | None:
    """Draw one file into the other; why not."""
    from launcher.errors import LauncherError
    from launcher.ros.draw.dot import to_dot, to_svg
    from launcher.ros.draw.filter import Filter, Mode

    try:
        drawing = to_svg(to_dot(Filter().apply(load(source)), Mode.ALL))
        Path(target).write_text(drawing, encoding="utf-8")
    except LauncherError as error:
        return ": ".join(filter(None, [error.message, error.hint]))
    except OSError as error:
        return f"{target}: {error.strerror}"
    return None


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
