"""The JUnit report of tests of launch_testing: a suite for each run."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import Any


def unittestResultsToXml(
    *, name: str = "launch_test", test_results: Mapping[Any, Any] | None = None
) -> ET.ElementTree:
    """The document for results by their runs."""
    results = {} if test_results is None else test_results
    root = ET.Element("testsuites", {"name": name, **_counts(*results.values())})
    for run, result in results.items():
        root.append(unittestResultToXml(str(run), result))
    return ET.ElementTree(root)


def unittestResultToXml(name: str, test_result: Any) -> ET.Element:
    skipped = str(len(test_result.skipped))
    suite = ET.Element("testsuite", {"name": name, **_counts(test_result), "skipped": skipped})
    suite.extend([unittestCaseToXml(test_result, case) for case in test_result.testCases])
    return suite


def unittestCaseToXml(test_result: Any, test_case: Any) -> ET.Element:
    method, _, qualifiers = test_case.id().partition(" ")
    classname, _, name = method.rpartition(".")
    element = ET.Element(
        "testcase",
        classname=classname,
        name=f"{name} {qualifiers}".strip(),
        time=_seconds(test_result.testTimes[test_case]),
    )
    for tag, found in (
        ("failure", test_result.failures),
        ("error", test_result.errors),
        ("skipped", test_result.skipped),
    ):
        for case, message in found:
            if case == test_case:
                ET.SubElement(element, tag, message=message)
    return element


def _counts(*results: Any) -> dict[str, str]:
    return {
        "tests": str(sum(result.testsRun for result in results)),
        "failures": str(sum(len(result.failures) for result in results)),
        "errors": str(sum(len(result.errors) for result in results)),
        "time": _seconds(sum(sum(result.testTimes.values()) for result in results)),
    }


def _seconds(time: float) -> str:
    return str(round(time, 3))
