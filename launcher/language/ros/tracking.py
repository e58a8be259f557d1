"""How often each full node name was used in a run."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext

_KEY = "unique_ros_node_names"


def add_node_name(context: LaunchContext, node_name: str) -> None:
    """Count one more use."""
    counts = dict(context.get_locals_as_dict().get(_KEY, {}))
    counts[node_name] = counts.get(node_name, 0) + 1
    context.extend_globals({_KEY: counts})


def get_node_name_count(context: LaunchContext, node_name: str) -> int:
    """The number of uses."""
    count: int = context.get_locals_as_dict().get(_KEY, {}).get(node_name, 0)
    return count
