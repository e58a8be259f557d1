"""Branches and texts of single things in the trees of plans."""

from __future__ import annotations

from launcher.launch.plan.tree import Branch

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.base.model.events import StateRequest
    from launcher.launch.plan.plan import PlannedProcess


def transition_branch(change: StateRequest, when: str) -> Branch:
    """A transition that is asked of a lifecycle node; `when` may be empty."""
    return Branch(f"{change.node}: {change.transition}", style="event", aside=when)


def load_branch(load: Any, when: str) -> Branch:
    """A component that is loaded; `when` may be empty."""
    lines = [("plain", f"{key}: {value}") for key, value in load.parameters]
    lines += [("plain", f"remap {old} to {new}") for old, new in load.remappings]
    lines += [("plain", f"extra argument {key}: {value}") for key, value in load.extra_arguments]
    aside = f"plugin {load.plugin} of {load.package}, into {load.container}"
    return Branch(
        f"component {full_name(load.namespace, load.name)}",
        style="process",
        aside=joined(aside, when),
        lines=lines,
    )


def time_text(time_s: float) -> str:
    """`at 5 s`; empty for the start."""
    return f"at {time_s:g} s" if time_s else ""


def identity(process: PlannedProcess) -> str:
    """`package/executable as /node`; empty for other programs."""
    ros = process.spec.ros
    if ros is None:
        return ""
    program = f"{ros.package}/{ros.executable}" if ros.package else str(ros.executable)
    if ros.node_name is None:
        return program
    return f"{program} as {full_name(ros.namespace, ros.node_name)}"


def full_name(namespace: str | None, name: str | None) -> str:
    """`/namespace/name`."""
    return f"{(namespace or '').rstrip('/')}/{name or ''}"


def joined(*texts: str) -> str:
    """Those that are not empty."""
    return ", ".join(filter(None, texts))


def restart_line(process: PlannedProcess) -> list[tuple[str, str]]:
    """How it is restarted; none if it is not."""
    if not process.respawn:
        return []
    limit = process.respawn_max_retries
    times = f", at most {limit} times" if isinstance(limit, int) and limit >= 0 else ""
    return [("aside", f"restarted {process.respawn_delay or 0.0:g} s after it exits{times}")]
