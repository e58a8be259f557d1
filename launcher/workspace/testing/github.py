"""The results of tests on GitHub: annotations where tests failed, and a summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from launcher.base.github import annotation, plain, table
from launcher.workspace.testing.package_results import Results

Judged = Mapping[str, tuple[Results, str]]  # package -> results, and why it did not pass


def commands(judged: Judged) -> Iterator[str]:
    for package, (found, problem) in judged.items():
        for one in found.failures:
            yield annotation(one.message, title=f"{package}: {one.test}", place=one.place)
        if problem and not found.failures:
            yield annotation(problem, title=package)


def summary(judged: Judged, total: str) -> Iterator[str]:
    """A row for each package, and one for each test that failed."""
    yield "### test\n"
    yield from table(
        ("", "package", "tests"),
        (
            (
                "FAILED" if problem else "passed" if found.passed else "no tests",
                package,
                str(found) if found.failed or not problem else problem,
            )
            for package, (found, problem) in judged.items()
        ),
    )
    failures = [
        (package, one.test, one.place, one.message)
        for package, (found, _) in judged.items()
        for one in found.failures
    ]
    if failures:
        yield ""
        yield from table(("package", "failed", "place", "message"), failures)
    yield f"\n{plain(total)}"
