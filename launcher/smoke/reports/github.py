"""A smoke run on GitHub: annotations at the lines of the expectations, and a summary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from launcher.base.errors import LauncherError
from launcher.base.github import annotation, plain, table
from launcher.smoke.reports import text_report
from launcher.smoke.reports.failure import describe
from launcher.smoke.reports.result import SmokeResult


def commands(result: SmokeResult) -> Iterator[str]:
    for one in result.failures:
        origin = one.expectation.origin
        yield annotation(
            "\n".join(describe(one, result.facts)[1:]),
            title=f"not met: {one.expectation.name}",
            place=f"{origin.text}:{origin.line}" if origin.line else "",
        )
    if result.trouble:
        yield annotation(result.trouble, title="smoke")


def summary(results: Sequence[SmokeResult], target: str) -> Iterator[str]:
    """The expectations, what was expected and seen; of several runs, how often they were met."""
    yield f"### smoke: {plain(target)}\n"
    if len(results) > 1:
        yield from _of_several(results)
        return
    (result,) = results
    rows = text_report.shown_rows(result)
    if rows:
        yield from table(
            ("", "expectation", "expected", "seen"),
            (
                (
                    "met" if one.is_met else "NOT MET",
                    one.expectation.name,
                    one.verdict.expected,
                    one.verdict.seen or "nothing",
                )
                for one in rows
            ),
        )
    if len(rows) < len(result.judged):
        yield f"\n{plain(text_report.left_out(result, rows))}"
    yield f"\n{plain(text_report.summary(result))}"


def _of_several(results: Sequence[SmokeResult]) -> Iterator[str]:
    rows = text_report.flake_rows(results)[: text_report.ROWS]
    head = ("", "met", "expectation", "min / median / max")
    yield from table(
        head, ((row.verdict, f"{row.met} of {row.runs}", row.name, row.spread) for row in rows)
    )
    yield f"\n{plain(text_report.flake_summary(results))}"


def refusal(error: LauncherError) -> Iterator[str]:
    """Annotations for errors before anything was run."""
    for one in getattr(error, "errors", (error,)):
        hint = f" ({one.hint})" if one.hint else ""
        yield annotation(f"{one.message}{hint}", title="smoke", place=one.where or "")


def refusal_summary(error: LauncherError, target: str) -> Iterator[str]:
    yield f"### smoke: {plain(target)}\n"
    for line in error.render().splitlines():
        yield f"{plain(line)}\n"
