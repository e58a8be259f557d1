"""Parameter files that the launcher writes for nodes."""

from __future__ import annotations

from launcher.language.diagnostics import ros2_quirks

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine


def write_parameter_file(
    context: LaunchContext, text: str, content: object, source: str | None = None
) -> str:
    """Write `text` to a new temporary file that the run deletes; `content` is its data.

    `source` is the file from which it was made.
    """
    from tempfile import NamedTemporaryFile  # only for nodes with parameters

    with NamedTemporaryFile(
        mode="w", encoding="utf-8", errors="surrogateescape", prefix="launch_params_", delete=False
    ) as file:
        file.write(text)
    host = getattr(context, "_host", None)  # none: a context of somebody's test
    if host is not None:
        host.remember_file(file.name, content, source)
    return file.name


def write_parameters(
    context: LaunchContext, node: str, parameters: dict[str, Any], origin: FileLine | None
) -> str:
    """Write a parameter file for one node, `/**` for any; the path."""
    from launcher.base.model.parameter_text import ExponentText, file_text

    for name, value in parameters.items():
        first = value[0] if isinstance(value, tuple) and value else value
        if isinstance(first, ExponentText) and hasattr(context, "_host"):
            ros2_quirks.number_is_text(context, name, first, origin)
    content = plain({node: {"ros__parameters": parameters}})
    return write_parameter_file(context, file_text(content), content)


def plain(value: object) -> Any:
    """The value with lists in place of tuples, as read from a YAML file."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value
