"""What the tests of a package have found, from the JUnit files of pytest and ctest."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby
from xml.etree import ElementTree

from launcher.base.text import count
from launcher.workspace.building.sources.source_text import shown
from launcher.workspace.testing.package_jobs import Job, ctest_summary

# A line of a traceback of pytest: `test/test_a.py:12: in test_b`, `...: AssertionError`; and of one
# of Python, which has the place of a SyntaxError.
_PLACE = re.compile(
    r"^(?:(?:E\s+)?([^\s:][^:\n]*):(\d+): |E?\s+File \"([^\"]+)\", line (\d+))", re.MULTILINE
)
_MISSING = re.compile(r"ModuleNotFoundError: No module named '([\w.]+)'")
_RAISED = re.compile(r"^E   (\S.*)$")  # not the statement, which is indented deeper
# After SIGINT, and a line of the stacks that faulthandler prints after SIGABRT.
_END = re.compile(
    r"^(/.*):(\d+): KeyboardInterrupt$|^  File \"(/.*)\", line (\d+) in ", re.MULTILINE
)
_SHORT = 200


@dataclass(frozen=True)
class FailedTest:
    """A test that failed, or could not be run; `place` is `FILE:LINE`, or empty."""

    test: str
    message: str
    place: str = ""

    def __str__(self) -> str:
        return ": ".join(filter(None, (self.place, self.test, self.message)))


@dataclass
class Results:
    """Counts of tests by how they ended."""

    passed: int = 0
    failed: int = 0
    skipped: int = 0
    failures: list[FailedTest] = field(default_factory=list)
    problem: str = ""  # why there may be more

    def __str__(self) -> str:
        """`4 passed, 1 failed`; counts that are 0 are left out."""
        counts = {"passed": self.passed, "failed": self.failed, "skipped": self.skipped}
        parts = [f"{number} {word}" for word, number in counts.items() if number]
        return ", ".join(parts) or "no tests"

    def add(self, other: Results) -> None:
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped
        self.failures += other.failures
        self.problem = self.problem or other.problem


def read(job: Job, *, is_complete: bool = True) -> Results:
    """The results of a job that has ended.

    pytest also lists the test in which it was interrupted, as if it had passed: of a job that is
    not complete only failures count.
    """
    found = _read(job)
    if not is_complete:
        found.passed = 0
    return found


def _read(job: Job) -> Results:
    if not job.is_ctest:
        return _read_file(job.results, job)
    total = Results()
    for case in _cases(ctest_summary(job.folder), total):
        name = case.get("name", "")
        own = os.path.join(job.results, f"{name}.xunit.xml")  # by ament's runner of tests
        if os.path.isfile(own):
            total.add(_read_file(own, job))
        else:
            _count(case, total, job)
    return total


def _read_file(path: str, job: Job) -> Results:
    results = Results()
    for case in _cases(path, results):
        _count(case, results, job)
    return results


def _cases(path: str, results: Results) -> Iterator[ElementTree.Element]:
    """The tests in a file; none if it does not exist."""
    try:
        root = ElementTree.parse(path).getroot()
    except FileNotFoundError:
        return
    except (OSError, ElementTree.ParseError) as error:
        results.problem = f"{path} cannot be read: {error}"
        return
    yield from root.iter("testcase")


def _count(case: ElementTree.Element, results: Results, job: Job) -> None:
    bad = [part for part in case if part.tag in ("failure", "error")]
    status = case.get("status")  # only of ctest
    if bad or status == "fail":
        results.failed += 1
        results.failures.append(_failure(case, bad, job))
    elif case.find("skipped") is not None or status in ("notrun", "disabled"):
        results.skipped += 1
    else:
        results.passed += 1


def _failure(case: ElementTree.Element, bad: list[ElementTree.Element], job: Job) -> FailedTest:
    text = (bad[0].text or "") if bad else ""
    return FailedTest(
        test=case.get("name", "?"),
        message=_message(bad[0].get("message") or "" if bad else "", text),
        place=_place(text, job) or _place_of_test(case, job),
    )


def _message(message: str, text: str) -> str:
    """The first line of what was raised."""
    lines = message.strip().splitlines()
    missing = _MISSING.search(text)
    if missing is not None:
        return missing[0]
    if lines == ["collection failure"]:
        lines = _raised(text) or lines
    if lines == ["internal error"]:  # also for SystemExit during the collection
        lines = text.strip().splitlines()[-1:] or lines
    return lines[0][:_SHORT] if lines else "failed"


def _raised(text: str) -> list[str]:
    """The lines of the last exception in a traceback of pytest."""
    lines = text.splitlines()
    blocks = [
        [*found] for is_error, found in groupby(lines, lambda one: one[:2] == "E ") if is_error
    ]
    found = map(_RAISED.match, blocks[-1] if blocks else ())
    return [line[1] for line in found if line is not None]


def _place(text: str, job: Job) -> str:
    """The innermost place of a traceback that is in the package, else the innermost of all."""
    found = (match.groups() for match in _PLACE.finditer(text))
    places = [(_absolute(one or other, job), line or last) for one, line, other, last in found]
    places = [(path, line) for path, line in places if os.path.isfile(path)]
    own = [one for one in places if one[0].startswith(job.source + os.sep)]
    chosen = (own or places)[-1:]
    return "".join(f"{shown(path)}:{line}" for path, line in chosen)


def _place_of_test(case: ElementTree.Element, job: Job) -> str:
    file, line = case.get("file"), case.get("line")
    if not file:
        return ""
    number = f":{int(line) + 1}" if line and line.isdigit() else ""  # pytest counts from 0
    return f"{shown(_absolute(file, job))}{number}"


def _absolute(path: str, job: Job) -> str:
    return os.path.normpath(os.path.join(job.source, path))


def place_of_end(job: Job) -> str:
    """Where in the package pytest was when it was ended, from its output; empty if unknown."""
    try:
        with open(job.log, encoding="utf-8", errors="replace") as file:
            text = file.read()
    except OSError:
        return ""
    # faulthandler escapes what is not ASCII.
    escaped = job.source.encode("ascii", "backslashreplace").decode()
    for match in _END.finditer(text):
        path, line = (match[1] or match[3]).replace(escaped, job.source), match[2] or match[4]
        if path.startswith(job.source + os.sep):
            return f"{shown(path)}:{line}"
    return ""


def total(results: list[Results], incomplete: Mapping[str, list[str]]) -> str:
    """`3 packages: 12 passed, 1 failed, 1 timed out (p)`; `incomplete` has packages by ending."""
    together = Results()
    for one in results:
        together.add(one)
    parts = [f"{len(names)} {why} ({', '.join(names)})" for why, names in incomplete.items()]
    if together.passed or together.failed or together.skipped or not parts:
        parts.insert(0, str(together))
    return f"{count(len(results), 'package')}: {', '.join(parts)}"
