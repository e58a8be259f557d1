"""Results of a run of tests, with the time of each."""

from __future__ import annotations

import time
import unittest
from types import SimpleNamespace
from typing import Any

from launcher.language.naming import public
from launcher.smoke.launch_tests.file_faults import skips


@public("launch_testing.test_result")
class FailResult(unittest.TestResult):
    """All tests of a run whose processes ended too early."""

    def __init__(self, test_run: Any, message: str) -> None:
        super().__init__()
        for case in test_run.all_cases():
            self.testsRun += 1
            self.addFailure(case, (Exception, Exception(message), None))  # type: ignore[arg-type]

    @property
    def testCases(self) -> list[Any]:
        return [case for case, _ in self.failures]

    @property
    def testTimes(self) -> dict[Any, float]:
        return dict.fromkeys(self.testCases, 0.0)

    def wasSuccessful(self) -> bool:
        return False


@public("launch_testing.test_result")
class SkipResult(unittest.TestResult):
    """All tests of a run whose description is skipped."""

    def __init__(self, test_run: Any, skip_reason: str = "") -> None:
        super().__init__()
        for case in test_run.all_cases():
            self.testsRun += 1
            self.addSkip(case, skip_reason)

    @property
    def testCases(self) -> list[Any]:
        return [case for case, _ in self.skipped]

    @property
    def testTimes(self) -> dict[Any, float]:
        return dict.fromkeys(self.testCases, 0.0)

    def wasSuccessful(self) -> bool:
        return True


class SkippedFile(unittest.TestCase):
    """Stands in a report for the tests of a file that skips itself."""

    def __init__(self, package: str, name: str) -> None:
        super().__init__("run")
        self._id = f"{package}.{name}"

    def id(self) -> str:
        return self._id


def skipped_file(package: str, name: str, reason: str) -> SkipResult:
    """The result of a file that skips itself."""
    case = SkippedFile(package, name)
    return SkipResult(SimpleNamespace(all_cases=lambda: [case]), reason)


@public("launch_testing.test_result")
class TestResult(unittest.TextTestResult):
    """Prints tests as they run, and keeps their times in seconds."""

    __test__ = False  # for pytest

    def __init__(self, stream: Any = None, descriptions: Any = None, verbosity: Any = None) -> None:
        self.__spans: dict[Any, tuple[float, float]] = {}
        super().__init__(stream, descriptions, verbosity)

    @property
    def testCases(self) -> Any:
        return self.__spans.keys()

    @property
    def testTimes(self) -> dict[Any, float]:
        return {case: end - start for case, (start, end) in self.__spans.items()}

    def startTest(self, test: Any) -> None:
        now = time.time()
        self.__spans[test] = (now, now)
        super().startTest(test)

    def addError(self, test: Any, err: Any) -> None:
        if issubclass(err[0], skips()):  # pytest's, which unittest does not know
            self.addSkip(test, str(err[1]))
        else:
            super().addError(test, err)

    def stopTest(self, test: Any) -> None:
        self.__spans[test] = (self.__spans[test][0], time.time())
        super().stopTest(test)

    def append(self, results: TestResult) -> None:
        """Add the results of the tests after the shutdown."""
        self.__spans.update(results.__spans)
        self.testsRun += results.testsRun
        for mine, others in (
            (self.failures, results.failures),
            (self.errors, results.errors),
            (self.skipped, results.skipped),
            (self.expectedFailures, results.expectedFailures),
        ):
            mine.extend(others)
        self.unexpectedSuccesses.extend(results.unexpectedSuccesses)
