"""LastLook: what is asked of the probe before a system is stopped."""

from __future__ import annotations

from launcher.errors import LauncherError
from launcher.smoke.system import System

CLOCK_S = 5.0


def deaf(system: System) -> str | None:
    """A sentence if the probe does not answer: it may have missed what was to be seen.

    Everything that came before the answer has been told by then.
    """
    if system.probe is None:
        return None
    try:
        system.probe.ask("clock", timeout_s=CLOCK_S)
        found = system.probe.ask("services")["services"]
        system.recorder.set_services(service["name"] for service in found)
    except LauncherError as error:
        return f"{error.message}, so that not everything may have been seen"
    return None
