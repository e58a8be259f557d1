"""The results of tests as annotations and as a summary."""

from __future__ import annotations

from launcher.workspace.testing import github
from launcher.workspace.testing.package_results import FailedTest, Results

FAILED = FailedTest("test_bad", "assert 1 == 2", "src/a/test/test_a.py:5")
JUDGED = {
    "a": (Results(passed=2, failed=1, failures=[FAILED]), "1 failed"),
    "b": (Results(passed=3), ""),
    "c": (Results(), "timed out after 3 s"),
    "d": (Results(), ""),
}


def test_each_failure_has_an_annotation():
    assert list(github.commands(JUDGED)) == [
        "::error file=src/a/test/test_a.py,line=5,title=a%3A test_bad::assert 1 == 2",
        "::error title=c::timed out after 3 s",
    ]


def test_the_summary_has_a_row_for_each_package_and_each_failure():
    assert "\n".join(github.summary(JUDGED, "4 packages: 5 passed, 1 failed")).splitlines() == [
        "### test",
        "",
        "|  | package | tests |",
        "| --- | --- | --- |",
        "| FAILED | a | 2 passed, 1 failed |",
        "| passed | b | 3 passed |",
        "| FAILED | c | timed out after 3 s |",
        "| no tests | d | no tests |",
        "",
        "| package | failed | place | message |",
        "| --- | --- | --- | --- |",
        "| a | test&#95;bad | src/a/test/test&#95;a.py&#58;5 | assert 1 == 2 |",
        "",
        "4 packages&#58; 5 passed, 1 failed",
    ]
    (*_, last) = github.summary({"b": JUDGED["b"]}, "1 package: 3 passed")
    assert last == "\n1 package&#58; 3 passed"
