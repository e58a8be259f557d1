"""Write the ROS graph of a run to `graph.json` and `graph.svg`.

The graph is recorded while the system runs and drawn afterwards: drawing takes seconds.
`python -m launcher.smoke.reports.graph_files JSON SVG` draws in a separate process, which can be
killed if a graph takes too long.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from launcher.base import strict_json
from launcher.base.ros_errors import VerbError
from launcher.posix.ports import busy_domains
from launcher.ros.snapshot.diff import load, to_document
from launcher.ros.snapshot.ros_graph import TopicGraph
from launcher.smoke.reports.artifacts import save

if TYPE_CHECKING:
    from launcher.smoke.run.system import System

# Limits for a busy machine and a graph of many nodes; usually it takes a second or two.
RECORD_S = 20.0
DRAW_S = 60.0
_RECORD = ("-m", "launcher", "graph", "--json", "--debug-topics", "--hidden")
_DRAW = ("-m", "launcher.smoke.reports.graph_files")


class GraphFiles:
    """The graph of a system, from its probe or, without one, from `launcher graph --json`.

    `always`: even without a probe.
    """

    def __init__(self, system: System, folder: Path, *, always: bool) -> None:
        self._system = system
        self._json = folder / "graph.json"
        self._svg = folder / "graph.svg"
        self._always = always
        self._recording: subprocess.Popen[bytes] | None = None

    def begin(self) -> None:
        """Record the graph in the background, unless the probe does; only the first call counts."""
        if not self._always or self._recording is not None or self._system.probe is not None:
            return
        if self._system.is_alive and self._system.domain_id in busy_domains():
            with self._json.open("wb") as file:
                self._recording = subprocess.Popen(
                    [sys.executable, *_RECORD],
                    stdin=subprocess.DEVNULL,
                    stdout=file,
                    stderr=subprocess.DEVNULL,
                    env=self._system.environment,
                    start_new_session=True,
                )

    def finish_recording(self) -> None:
        """Wait until the graph is recorded; afterwards the system may be stopped."""
        if self._recording is None:
            return
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._recording.wait(RECORD_S)
        if self._recording.poll() is None:
            self._recording.kill()
            self._recording.wait()

    def draw(self) -> str | None:
        """Write the files; returns why one is missing."""
        if not self._always and self._system.probe is None:
            return None
        snapshot = self._snapshot()
        if snapshot is None:
            self._json.unlink(missing_ok=True)
            return f"no drawing of the ROS graph: {self._why()}"
        text = strict_json.dumps(to_document(snapshot), indent=2, ensure_ascii=False)
        try:
            save(self._json, f"{text}\n")
        except OSError as error:
            return f"no drawing of the ROS graph: {error.strerror}"
        return self._draw_svg()

    def _snapshot(self) -> TopicGraph | None:
        """The last graph with live nodes before the stop."""
        if self._recording is not None:
            with contextlib.suppress(VerbError):
                return load(str(self._json))
            return None
        facts = self._system.facts()
        for seen in reversed(facts.graphs):
            alive = set(seen.snapshot.nodes) - set(seen.snapshot.ghosts)
            if alive and seen.at_s <= facts.stop_s:
                return seen.snapshot
        return None

    def _why(self) -> str:
        if self._recording is not None:
            return "it could not be recorded in time"
        facts = self._system.facts()
        if self._system.probe is None and any(facts.node_names.values()):
            return "the system exited before it was recorded"
        return "no ROS node was observed"

    def _draw_svg(self) -> str | None:
        try:
            done = subprocess.run(
                [sys.executable, *_DRAW, str(self._json), str(self._svg)],
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
            reason = (done.stderr.strip().splitlines() or ["unknown error"])[-1]
            return f"no drawing of the ROS graph: {reason}"
        return None


def main(source: str, target: str) -> str | None:
    """Draw `source` (JSON) as `target` (SVG); returns the error, if any."""
    from launcher.base.errors import LauncherError
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
