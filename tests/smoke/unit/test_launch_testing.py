"""What tests of launch_testing use: handlers of output, assertions, and matching of text."""

from __future__ import annotations

import io
import re
import threading
import unittest
from types import ModuleType, SimpleNamespace

import pytest

from launcher.language.actions.process import ExecuteProcess
from launcher.language.actions.timer import TimerAction
from launcher.language.compat import vocabulary
from launcher.language.description import LaunchDescription
from launcher.language.testing import (
    ReadyToTest,
    keep_alive,
    parametrize,
    ready_to_test_action_timeout,
)
from launcher.smoke.launch_tests.asserts import (
    SequentialTextChecker,
    assertExitCodes,
    assertInStderr,
    assertInStdout,
)
from launcher.smoke.launch_tests.junit import unittestResultsToXml
from launcher.smoke.launch_tests.loading import LoadTestsFromPythonModule, ready_actions
from launcher.smoke.launch_tests.observations import (
    ActiveIoHandler,
    ActiveProcInfoHandler,
    IoHandler,
    ReadyAggregator,
)
from launcher.smoke.launch_tests.process_lookup import (
    NO_CMD_ARGS,
    NoMatchingProcessException,
    resolveProcesses,
)
from launcher.smoke.launch_tests.results import FailResult, SkipResult, TestResult
from launcher.smoke.launch_tests.running import PhaseReporter
from launcher.smoke.launch_tests.test_actions import GTest, PyTest
from launcher.smoke.launch_tests.text_matching import (
    basic_output_filter,
    build_line_match,
    build_text_match,
    expect_output,
    expected_output_from_file,
)


class Recorded:
    """An action of a process that has started."""

    def __init__(self, process_details: dict[str, object]) -> None:
        self.process_details = process_details


def event(name: str, text: str = "", *words: str, stream: str = "stdout", returncode: int = 0):
    action = Recorded({"name": name, "cmd": ["program", *words]})
    return SimpleNamespace(
        action=action,
        process_name=name,
        text=text.encode(),
        from_stdout=stream == "stdout",
        from_stderr=stream == "stderr",
        returncode=returncode,
    )


def output(*events, handler=None):
    handler = handler or IoHandler()
    for one in events:
        handler.append(one)
    return handler


@pytest.mark.parametrize(
    ("expected", "strict", "text", "span"),
    [
        ("b", False, "abc", (1, 2)),
        ("b", True, "abc", None),
        ("abc", True, "abc", (0, 3)),
        ("a\nb", False, "a\r\nb", (0, 3)),
        (re.compile(r"\d+"), False, "a12", (1, 3)),
        (re.compile(r"\d+"), True, "a12", None),
        (["a", re.compile("c")], False, "abc", (0, 3)),
        (["c", "a"], False, "abc", None),
        (["a", "c"], True, "abc", None),
        (["a", "b"], True, "abc", (0, 2)),
    ],
)
def test_texts_are_found(expected, strict: bool, text: str, span):
    assert build_text_match(expected, strict=strict)(text) == span


@pytest.mark.parametrize(
    ("expected", "strict", "span"),
    [
        ("w", False, (1, 2)),
        ("one", True, None),
        (re.compile("t"), False, (1, 2)),
        (["one", "three"], False, (0, 3)),
        (["one", "three"], True, None),
        (["one", "two"], True, (0, 2)),
    ],
)
def test_lines_are_found(expected, strict: bool, span):
    assert build_line_match(expected, strict=strict)(["one", "two", "three"], 0) == span


def test_what_is_no_expectation_is_refused():
    for build in (build_text_match, build_line_match):
        with pytest.raises(ValueError, match="Unknown format for expected"):
            build(3)
    with pytest.raises(ValueError, match="Either lines or text"):
        expect_output("a", lines=["a"], expected_text="a")
    with pytest.raises(ValueError, match="Either expected lines or text"):
        expect_output("a", expected_text="a", expected_lines=["a"])


def test_expected_output_of_a_file_is_lines_or_patterns(tmp_path):
    (tmp_path / "a.txt").write_text("one\ntwo\n")
    (tmp_path / "b.regex").write_text(r"t\w+")
    text = "\x1b[31mone\x1b[0m\ntwo\n"
    for name in ("a", "b"):
        expected = expected_output_from_file(str(tmp_path / name))
        assert expect_output(text, expected_lines=expected)
    with pytest.raises(RuntimeError, match="could not find output check file"):
        expected_output_from_file(str(tmp_path / "c"))
    assert basic_output_filter(filtered_patterns=["t"])("pid 1\nrc 2\none\ntwo\n") == "one\n"


def test_a_process_is_found_by_its_action_or_a_part_of_its_name():
    first, second = event("talker-1", "a"), event("talker-2", "b", "--loud")
    handler = output(first, second)

    assert resolveProcesses(handler) == [first.action, second.action]
    for given, found in (
        ({"process": "talker-1"}, first),
        ({"process": "talker", "cmd_args": "--loud"}, second),
        ({"process": "talker", "cmd_args": NO_CMD_ARGS}, first),
    ):
        assert resolveProcesses(handler, **given) == [found.action]
    assert len(resolveProcesses(handler, process="talker", strict_proc_matching=False)) == 2
    with pytest.raises(Exception, match=r"Found multiple .* Procs: talker-1, talker-2 --loud"):
        resolveProcesses(handler, process="talker")
    with pytest.raises(NoMatchingProcessException, match=r"'x' and args 'None'. Procs: talker"):
        resolveProcesses(handler, process="x")
    with pytest.raises(NoMatchingProcessException, match="No data recorded for any process"):
        resolveProcesses(IoHandler())
    with pytest.raises(NoMatchingProcessException, match="No data recorded for proc echo hello"):
        resolveProcesses(handler, process=ExecuteProcess(cmd=["echo", "hello"]))
    with pytest.raises(TypeError, match="must be 'ExecuteProcess' or 'str'"):
        resolveProcesses(handler, process=3)


def test_output_is_asserted_by_stream():
    handler = output(event("a-1", "\x1b[1mgood\x1b[0m"), event("b-2", "bad", stream="stderr"))

    assertInStdout(handler, "good", "a-1")
    assertInStderr(handler, re.compile("b.d"), "b-2")
    assertInStdout(handler, "GOOD", "a-1", output_filter=str.upper)
    with pytest.raises(AssertionError, match=r"Did not find 'bad' in .* processes: a-1"):
        assertInStderr(handler, "bad", "a-1")


def test_exit_codes_are_asserted():
    handler = output(event("a-1"), event("b-2", returncode=130), handler=ActiveProcInfoHandler())

    assertExitCodes(handler, process="a-1")
    assertExitCodes(handler, [0, 130])
    with pytest.raises(AssertionError, match="Proc b-2 exited with code 130"):
        assertExitCodes(handler)
    with pytest.raises(AssertionError, match="is not an int"):
        assertExitCodes(handler, ["0"])


def test_a_sequence_goes_on_behind_each_match_and_names_the_lines_around_it():
    checker = SequentialTextChecker(["one\n", "two\nthree\n", "four\n", "five\n", "six\n"])

    checker.assertInStdout("two")
    checker.assertInText("three")
    with pytest.raises(AssertionError, match="'two' not found in sequence after previous match"):
        checker.assertInStdout("two")
    assert checker.get_nearby_lines() == "one\ntwo\nthree\nfour\nfive\nsix"


def test_output_is_waited_for_in_another_thread():
    handler = output(event("a-1", "first\n", stream="stderr"), handler=ActiveIoHandler())
    writer = threading.Timer(0.05, lambda: handler.append(event("a-1", "second", stream="stderr")))
    writer.start()

    handler.assertWaitFor("second", timeout=60)
    assert not handler.waitFor("third", timeout=0)
    with pytest.raises(AssertionError, match="Waiting for output timed out"):
        handler.assertWaitFor("third", timeout=0)
    with pytest.raises(NoMatchingProcessException):
        handler.waitFor("third", "nobody", timeout=0)


def test_starts_and_ends_are_waited_for():
    handler = output(event("a-1"), handler=ActiveProcInfoHandler())

    handler.assertWaitForStartup("a-1", timeout=0)
    with pytest.raises(AssertionError, match="Timed out waiting for process 'a-1' to finish"):
        handler.assertWaitForShutdown("a-1", timeout=0)
    with pytest.raises(AssertionError, match="Timed out waiting for process 'b' to start"):
        handler.assertWaitForStartup("b", timeout=0)


def test_the_last_of_several_is_ready():
    calls: list[int] = []
    aggregator = ReadyAggregator(lambda: calls.append(1), 2)

    assert [aggregator.ready_fn() or len(calls) for _ in range(3)] == [0, 1, 1]


def module(description, *cases: type) -> ModuleType:
    made = ModuleType("made")
    vars(made).update(
        {case.__name__: case for case in cases}, generate_test_description=description
    )
    return made


class WhileRunning(unittest.TestCase):
    __test__ = False

    def setUp(self, value=None):
        self.value = value

    def test_value(self, value):
        self.assertEqual((self.value, self.given), (value, "given"))


class AfterRunning(unittest.TestCase):
    __test__ = False
    __post_shutdown_test__ = True

    def test_nothing(self):
        pass


def marked(*marks):
    """A description with these marks, the first one at the bottom."""

    def description(value=None):
        return LaunchDescription([TimerAction(period=1.0, actions=[ReadyToTest()])])

    for mark in marks:
        description = mark(description)
    return description


@pytest.mark.parametrize("order", [1, -1])
def test_marks_may_stand_in_any_order(order: int):
    marks = [parametrize("value", [1, 2]), keep_alive, ready_to_test_action_timeout(3)][::order]
    runs = LoadTestsFromPythonModule(module(marked(*marks)))

    assert [(str(run), run.timeout, run.markers) for run in runs] == [
        (f"launch_tests[{value}]", 3, {"keep_alive": True}) for value in (1, 2)
    ]


def test_a_run_has_its_tests_of_both_phases_with_what_they_ask_for():
    description = marked(parametrize("value", [5]))
    (run,) = LoadTestsFromPythonModule(module(description, WhileRunning, AfterRunning))
    run.bind(run.pre_shutdown_tests, {"given": "given"}, {"value": 5, "more": 6})
    result = TestResult(io.StringIO(), False, 0)
    result.stream = unittest.runner._WritelnDecorator(io.StringIO())
    run.pre_shutdown_tests.run(result)

    assert result.wasSuccessful(), result.errors
    ids = [case.id() for case in run.all_cases()]
    assert [one.rpartition(".")[2] for one in ids] == ["test_value[5]", "test_nothing[5]"]
    ready: list[str] = []
    found, _ = run.normalized_test_description(ready_fn=lambda: ready.append("ready"))
    next(ready_actions(found.entities)).execute(None)
    assert ready == ["ready"]


def test_results_of_what_did_not_run_are_in_the_report():
    (run,) = LoadTestsFromPythonModule(module(marked(), WhileRunning, AfterRunning))
    results = {"skipped": SkipResult(run, "why"), "failed": FailResult(run, "because")}
    root = unittestResultsToXml(name="all", test_results=results).getroot()

    assert (root.get("tests"), root.get("failures"), root.get("errors")) == ("4", "2", "0")
    messages = [one.get("message", "").strip() for suite in root for case in suite for one in case]
    assert messages == ["why"] * 2 + ["Exception: because"] * 2


@pytest.mark.parametrize(("kind", "value"), [(GTest, 5), (PyTest, 2)])
def test_a_timeout_without_a_point_is_named(kind: type, value: int):
    text = rf"timeout of {kind.__name__} takes a float.* write {value}\.0"
    with pytest.raises(TypeError, match=text):
        kind(path="some", timeout=value).execute(None)


def test_the_thread_of_a_launch_that_has_died_reports_nothing(capsys):
    reporter = PhaseReporter()

    class Two(unittest.TestCase):
        def test_a(self):
            reporter.close()

        def test_b(self):
            raise AssertionError

    result = reporter.run(unittest.TestLoader().loadTestsFromTestCase(Two))

    assert result.testsRun == 1
    assert "... ok" not in capsys.readouterr().err


def test_the_packages_have_what_tests_import():
    with vocabulary():
        import launch_testing.actions
        import launch_testing.asserts
        import launch_testing.pytest.hooks
        from launch_pytest import fixture, tools
        from launch_testing import parametrize
        from launch_testing import tools as testing_tools
        from launch_testing.test_runner import LaunchTestRunner, _RunnerWorker
        from launch_testing.tools.process import ProcessProxy

        assert callable(parametrize) and callable(fixture) and callable(tools.wait_for_exit)
        assert testing_tools.ProcessProxy is ProcessProxy
        actions = launch_testing.actions
        assert actions.GTest(path="a", timeout=3.0).timeout == 3.0
        assert actions.PyTest(path="t").path == "t"
        assert launch_testing.asserts.assertDefaultStream() == "stderr"
        assert LaunchTestRunner and _RunnerWorker and launch_testing.pytest.hooks.LaunchTestItem
