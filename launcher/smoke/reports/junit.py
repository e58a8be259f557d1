"""The results as JUnit XML for CI servers: one case for each expectation."""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from launcher.base.errors import ExitCode, LauncherError
from launcher.smoke.reports.artifacts import save
from launcher.smoke.reports.failure import describe
from launcher.smoke.reports.result import Judged, SmokeResult

# Characters that XML 1.0 cannot represent.
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write(path: Path, results: Sequence[SmokeResult], target: str) -> None:
    """One suite for each run."""
    names = [target]
    if len(results) > 1:
        names = [f"{target} run {number}" for number in range(1, len(results) + 1)]
    _save(path, [_of_run(one, name, target) for one, name in zip(results, names, strict=True)])


def write_refusal(path: Path, error: LauncherError, target: str) -> None:
    """One case with all errors, where nothing was run."""
    message = f"{error.where}: {error.message}" if error.where else error.message
    case = _error_case(target, message, error.render())
    _save(path, [_suite(target, [case], errors=1)])


def _save(path: Path, suites: Sequence[ElementTree.Element]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    root = ElementTree.Element("testsuites", name="smoke")
    root.extend(suites)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    save(path, f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n')


def _of_run(result: SmokeResult, name: str, target: str) -> ElementTree.Element:
    judged = () if result.exit_code is ExitCode.USAGE else result.judged
    cases = [_case(one, result, target) for one in judged]
    reasons = ["interrupted"] * bool(result.interrupted) + ["not ready in time"] * result.gave_up
    reasons += [result.trouble] if result.trouble else []
    if reasons:
        cases.append(_error_case(target, reasons[0], "\n".join([*reasons, *result.last_lines])))
    failures = sum(not one.is_met for one in judged)
    now = time.strftime("%Y-%m-%dT%H:%M:%S")
    suite = _suite(name, cases, failures, bool(reasons), result.facts.now_s)
    suite.set("timestamp", now)
    return suite


def _suite(
    name: str,
    cases: Sequence[ElementTree.Element],
    failures: int = 0,
    errors: int = 0,
    time_s: float = 0.0,
) -> ElementTree.Element:
    counts = {"failures": f"{failures}", "errors": f"{int(errors)}", "skipped": "0"}
    suite = _element("testsuite", name=name, tests=f"{len(cases)}", **counts, time=f"{time_s:.3f}")
    suite.extend(cases)
    return suite


def _case(one: Judged, result: SmokeResult, target: str) -> ElementTree.Element:
    verdict, origin = one.verdict, one.expectation.origin
    time_s = max(0.0, verdict.at_s or 0.0)
    names = {"classname": target, "name": one.expectation.name}
    place = {"file": origin.text, "line": str(origin.line)} if origin.line else {}
    case = _element("testcase", **names, time=f"{time_s:.3f}", **place)
    if not one.is_met:
        kind, message = one.expectation.kind, verdict.seen or "not met"
        failure = _element("failure", message=message, type=kind)
        failure.text = _clean("\n".join(describe(one, result.facts)))
        case.append(failure)
    return case


def _error_case(target: str, message: str, text: str) -> ElementTree.Element:
    case = _element("testcase", classname=target, name="run", time="0.000")
    error = _element("error", message=message, type="run")
    error.text = _clean(text)
    case.append(error)
    return case


def _element(tag: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.Element(tag, {name: _clean(text) for name, text in attributes.items()})


def _clean(text: str) -> str:
    return _FORBIDDEN.sub("\ufffd", text)
