"""LastLook: what is asked of the probe before a system is stopped."""

from __future__ import annotations

from collections.abc import Callable

from launcher.errors import LauncherError
from launcher.smoke.system import System

CLOCK_S = 5.0
DRAW_S = 20.0
MEET_S = 5.0  # a probe that comes late gets to know the nodes one after the other


def deaf(system: System) -> str | None:
    """A sentence if the probe does not answer: it may have missed what was to be seen.

    Everything that came before the answer has been told by then.
    """
    if system.probe is None:
        return None
    try:
        system.probe.ask("clock", timeout_s=CLOCK_S)
    except LauncherError as error:
        return f"{error.message}, so that not everything may have been seen"
    return None


def draw(system: System, say: Callable[[str], None]) -> None:
    """`graph.json` and `graph.svg`, and the services that there are."""
    nodes = {name for names in system.facts().node_names.values() for name in names}
    if system.probe is None:
        if not nodes or not system.is_alive:
            return
        system.add_probe()
        system.recorder.wait_for(lambda facts: nodes <= set(facts.graph().nodes), MEET_S)
    if system.probe is None:
        return
    try:
        found = system.probe.ask("services")["services"]
        system.recorder.set_services(service["name"] for service in found)
        drawn = system.probe.ask(
            "draw",
            timeout_s=DRAW_S,
            json=str((system.folder / "graph.json").absolute()),
            svg=str((system.folder / "graph.svg").absolute()),
        )
        for note in drawn.get("notes", ()):
            say(f"graph: {note}")
    except LauncherError as error:
        say(f"no picture of the graph: {error.message}")
