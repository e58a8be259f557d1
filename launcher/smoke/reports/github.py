"""Annotations of a GitHub workflow at the lines of the expectations."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from launcher.errors import LauncherError
from launcher.smoke.reports.failure import describe
from launcher.smoke.reports.result import Judged, Result


def commands(result: Result) -> Iterator[str]:
    for one in result.failures:
        message = _data("\n".join(describe(one, result.facts)[1:]))
        yield f"::error {_properties(one)}::{message}"
    if result.trouble:
        yield f"::error title=smoke::{_data(result.trouble)}"


def refusal(error: LauncherError) -> Iterator[str]:
    """The same for errors before anything was run."""
    for one in getattr(error, "errors", (error,)):
        path, _, line = (one.where or "").rpartition(":")
        place = f"file={_property(_relative(path))},line={line}," if line.isdigit() else ""
        text = one.message + (f" ({one.hint})" if one.hint else "")
        yield f"::error {place}title=smoke::{_data(text)}"


def _properties(one: Judged) -> str:
    properties = {"title": f"not met: {one.expectation.name}"}
    origin = one.expectation.origin
    if origin.line:
        properties = {"file": _relative(origin.text), "line": str(origin.line), **properties}
    return ",".join(f"{name}={_property(value)}" for name, value in properties.items())


def _relative(path: str) -> str:
    """Relative to the root of the repository, where workflows run."""
    try:
        return str(Path(path).absolute().relative_to(Path.cwd()))
    except ValueError:
        return path


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
