"""What launch files may use, and the first distribution of ROS 2 that has it.

Distributions are compared as they are today: what was added to Jazzy later counts as Jazzy's.
"""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.launch_session import DISTRIBUTIONS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.diagnostics.origin import FileLine

TARGETS = ("jazzy", "kilted", "lyrical")


def _table(**names: str) -> dict[str, str]:
    return {name: first for first, given in names.items() for name in given.split(", ")}


# Names as LaunchSession.note_use has them: `<tag>`, `<tag attribute>`, `$(word)`, a Python name.
FIRST = _table(
    jazzy=(
        "$(all), $(any), <include let>, PathSubstitution, "
        "<lifecycle_node>, <lifecycle_node autostart>, ComposableLifecycleNode, <set_use_sim_time>"
    ),
    kilted=(
        "<for>, <for_each>, $(for-var), $(index), "
        "ForEach, ForLoop, ForEachVar, ForLoopIndex, StringJoinSubstitution"
    ),
    lyrical=(
        "<log level>, <log_debug>, <log_info>, <log_warning>, <log_error>, "
        "Log, LogDebug, LogWarning, LogError, <bool_arg>, DeclareBooleanLaunchArgument, "
        "<rep_env>, ReplaceEnvironmentVariables, $(string-join), $(path-join), "
        "EventHandler(entities=ENTITY), <composable_lifecycle_node>, "
        "<trace snapshot-mode>, <trace dual-session>"
    ),
)


def warnings(
    uses: Iterable[tuple[str, FileLine]], distribution: str | None, *, is_target: bool
) -> list[str]:
    """A line for each use of what this distribution does not have; none if it is not known."""
    if distribution not in DISTRIBUTIONS:
        return []
    role = "the target is" if is_target else "installed is"
    return [
        f"warning: {place}: {name} needs ROS 2 {FIRST[name].title()}; {role} {distribution.title()}"
        for name, place in dict.fromkeys(uses)
        if name in FIRST and DISTRIBUTIONS.index(FIRST[name]) > DISTRIBUTIONS.index(distribution)
    ]
