"""The results as JUnit XML for CI servers: one case for each expectation."""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from launcher.errors import ExitCode, LauncherError
from launcher.smoke.reports.artifacts import save
from launcher.smoke.reports.failure import describe
from launcher.smoke.reports.result import Judged, Result

# Characters that XML 1.0 cannot represent.
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write(path: Path, results: Sequence[Result], target: str) -> None:
    """One suite for each run."""
    root = ElementTree.Element("testsuites", name="smoke")
    for number, result in enumerate(results, 1):
        name = target if len(results) == 1 else f"{target} run {number}"
        root.append(_suite(result, name, target))
    _save(path, root)


def write_refusal(path: Path, error: LauncherError, target: str) -> None:
    """One case with all errors, where nothing was run."""
    root = ElementTree.Element("testsuites", name="smoke")
    counts = {"tests": "1", "failures": "0", "errors": "1", "skipped": "0", "time": "0.000"}
    suite = ElementTree.SubElement(root, "testsuite", {"name": _clean(target), **counts})
    names = {"classname": _clean(target), "name": "run", "time": "0.000"}
    case = ElementTree.SubElement(suite, "testcase", names)
    _add_error(
        case, f"{error.where}: {error.message}" if error.where else error.message, error.render()
    )
    _save(path, root)


def _save(path: Path, root: ElementTree.Element) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    save(path, f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n')


def _suite(result: Result, name: str, target: str) -> ElementTree.Element:
    judged = () if result.exit_code is ExitCode.USAGE else result.judged
    cases = [_case(one, result, target) for one in judged]
    errors = 0
    if result.trouble or result.gave_up or result.interrupted:
        cases.append(_error_case(result, target))
        errors = 1
    suite = ElementTree.Element(
        "testsuite",
        name=_clean(name),
        tests=str(len(cases)),
        failures=str(sum(not one.is_met for one in judged)),
        errors=str(errors),
        skipped="0",
        time=f"{result.facts.now_s:.3f}",
        timestamp=time.strftime("%Y-%m-%dT%H:%M:%S"),
    )
    suite.extend(cases)
    return suite


def _case(one: Judged, result: Result, target: str) -> ElementTree.Element:
    verdict = one.verdict
    case = ElementTree.Element(
        "testcase",
        classname=_clean(target),
        name=_clean(one.expectation.name),
        time=f"{max(0.0, verdict.at_s or 0.0):.3f}",
    )
    if one.expectation.origin.line:
        case.set("file", _clean(one.expectation.origin.text))
        case.set("line", str(one.expectation.origin.line))
    if not one.is_met:
        failure = ElementTree.SubElement(
            case, "failure", message=_clean(verdict.seen or "not met"), type=one.expectation.kind
        )
        failure.text = _clean("\n".join(describe(one, result.facts)))
    return case


def _error_case(result: Result, target: str) -> ElementTree.Element:
    case = ElementTree.Element("testcase", classname=_clean(target), name="run", time="0.000")
    reasons = ["interrupted"] * bool(result.interrupted) + ["not ready in time"] * result.gave_up
    reasons += [result.trouble] if result.trouble else []
    _add_error(case, reasons[0], "\n".join([*reasons, *result.last_words]))
    return case


def _add_error(case: ElementTree.Element, message: str, text: str) -> None:
    error = ElementTree.SubElement(case, "error", message=_clean(message), type="run")
    error.text = _clean(text)


def _clean(text: str) -> str:
    return _FORBIDDEN.sub("\ufffd", text)
