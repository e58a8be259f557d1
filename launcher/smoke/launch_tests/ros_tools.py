"""What launch_testing_ros has besides topics: isolation, and filters of output."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from launcher.language.action import Action
from launcher.language.naming import public
from launcher.posix.domain_lease import leased_domain
from launcher.smoke.launch_tests import text_matching

_LEASES: list[Any] = []


@public("launch_testing_ros.actions.enable_rmw_isolation")
class EnableRmwIsolation(Action):
    """Gives the processes after it, and the test, a ROS domain that is free on this machine."""

    def execute(self, context: Any) -> None:
        lease = leased_domain()
        _LEASES.append(lease)  # until this process ends: those of the launch end before it
        context.environment["ROS_DOMAIN_ID"] = str(lease.__enter__())


def get_rmw_output_filter(rmw_implementation: str, filter_type: str) -> list[str]:
    """Lines that a middleware writes: `prefixes` or `patterns`, from its resource."""
    import ament_index_python

    if filter_type not in ("prefixes", "patterns"):
        raise TypeError(
            f"Unsupported filter_type \"{filter_type}\". Supported types: ['prefixes', 'patterns']"
        )
    resource = f"rmw_output_{filter_type}"
    if not ament_index_python.has_resource(resource, rmw_implementation):
        return []
    content, _ = ament_index_python.get_resource(resource, rmw_implementation)
    return list(content.splitlines())


def basic_output_filter(
    filtered_prefixes: Iterable[str] | None = None,
    filtered_patterns: Iterable[str] | None = None,
    filtered_rmw_implementation: str | None = None,
) -> Callable[[str], str]:
    """That of launch_testing, which also leaves out lines of the middleware."""
    prefixes = list(text_matching.FILTERED_PREFIXES)
    if filtered_prefixes is not None:
        prefixes = list(filtered_prefixes)
    patterns = list(filtered_patterns or ())
    if filtered_rmw_implementation:
        prefixes += get_rmw_output_filter(filtered_rmw_implementation, "prefixes")
        patterns += get_rmw_output_filter(filtered_rmw_implementation, "patterns")
    return text_matching.basic_output_filter(prefixes, patterns)
