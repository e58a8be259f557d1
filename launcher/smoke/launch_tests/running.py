"""Runs tests of launch_testing: the launch in this thread, the tests while it runs in another."""

from __future__ import annotations

import inspect
import sys
import threading
import unittest
from collections.abc import Mapping, Sequence
from typing import Any

from launcher.language.actions.event_actions import RegisterEventHandler
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.actions.process import OnProcessExit, OnProcessIO, OnProcessStart
from launcher.language.description import LaunchDescription
from launcher.language.naming import public
from launcher.language.ros.cli_api import parse_launch_arguments
from launcher.language.service import LaunchService
from launcher.language.sources import LaunchDescriptionSource
from launcher.smoke.launch_tests.asserts import written
from launcher.smoke.launch_tests.file_faults import skips
from launcher.smoke.launch_tests.loading import TestRun
from launcher.smoke.launch_tests.observations import ActiveIoHandler, ActiveProcInfoHandler
from launcher.smoke.launch_tests.results import FailResult, SkipResult, TestResult
from launcher.smoke.launch_tests.test_calls import raise_interrupt


class LaunchDiedError(Exception):
    """The launch ended before its tests did."""


class RunnerWorker:
    """One launch with its tests."""

    def __init__(
        self,
        test_run: TestRun,
        test_run_preamble: Sequence[Any],
        launch_file_arguments: Sequence[str] = (),
        debug: bool = False,
    ) -> None:
        self._test_run = test_run
        self._preamble = test_run_preamble
        self._arguments = parse_launch_arguments(launch_file_arguments)
        self._launch_service = LaunchService(debug=debug)
        self._launch_service.context._is_of_test = True
        self._processes_launched = threading.Event()
        self._tests_completed = threading.Event()
        self._results: Any = None
        self._error: BaseException | None = None
        self._info = ActiveProcInfoHandler()
        self._output = ActiveIoHandler()
        self._reporter = PhaseReporter()

    def run(self) -> Any:
        """The results of all tests. LaunchDiedError if the launch ended before them.

        KeyboardInterrupt if a Ctrl-C has ended it.
        """
        run = self._test_run
        description, context = run.normalized_test_description(
            ready_fn=self._processes_launched.set
        )
        self._bind({**context, **run.param_args})
        self._launch_service.include_launch_description(self._observed(description))
        # Signals and the control of a terminal belong to the main thread, that of the launch.
        thread = threading.Thread(target=self._run_test, name="test_runner_thread", daemon=True)
        thread.start()
        self._launch_service.run(shutdown_when_idle=not run.markers.get("keep_alive", False))
        has_completed = self._tests_completed.is_set()
        self._reporter.close()
        self._processes_launched.set()  # nobody waits for the thread, and it has nothing to do
        raise_interrupt(self._launch_service)
        if not has_completed:
            print("Processes under test stopped before tests completed")
            self._print_failed_processes()
            raise LaunchDiedError
        thread.join()
        self._results.append(PhaseReporter().run(run.post_shutdown_tests))
        return self._results

    def _bind(self, context: Mapping[str, Any]) -> None:
        run = self._test_run
        arguments = dict(self._arguments)
        running = {
            "launch_service": self._launch_service,
            "proc_info": self._info,
            "proc_output": self._output,
            "test_args": arguments,
        }
        ended = {
            "proc_info": self._info._proc_info_handler,
            "proc_output": self._output._io_handler,
            "test_args": arguments,
        }
        run.bind(run.pre_shutdown_tests, running, {**context, **running})
        run.bind(run.post_shutdown_tests, ended, {**context, **ended})

    def _observed(self, description: Any) -> LaunchDescription:
        info, output = self._info, self._output

        def started(event: Any, context: Any) -> None:
            info.append(event)
            output.track(event.process_name)

        handlers = (
            OnProcessStart(on_start=started),
            OnProcessExit(on_exit=lambda event, context: info.append(event)),
            OnProcessIO(on_stdout=output.append, on_stderr=output.append),
        )
        return LaunchDescription(
            [
                *self._preamble,
                *map(RegisterEventHandler, handlers),
                IncludeLaunchDescription(
                    LaunchDescriptionSource(launch_description=description),
                    launch_arguments=self._arguments,
                ),
            ]
        )

    def _run_test(self) -> None:
        """In its thread: the tests of the running processes."""
        if not self._processes_launched.wait(self._test_run.timeout):
            print("Timed out waiting for processes to start up")
            self._launch_service.shutdown()
            return
        if self._reporter.is_closed:
            return
        try:
            self._results = self._reporter.run(self._test_run.pre_shutdown_tests)
        finally:
            self._tests_completed.set()
            self._launch_service.shutdown()

    def _print_failed_processes(self) -> None:
        for event in self._info:
            if getattr(event, "returncode", None) == 0:
                continue
            name = event.process_name
            print(f"Process '{name}' exited with {getattr(event, 'returncode', None)}")
            title = f"##### '{name}' output #####"
            print(title)
            if name in self._output.process_names():
                print(written(self._output[name]))
            print("#" * len(title))


class PhaseReporter:
    """Runs tests, and reports them on standard error until `close`.

    The thread of tests whose launch has died goes on; it begins no other test, and says nothing.
    """

    def __init__(self) -> None:
        self.is_closed = False
        self._stream = sys.stderr
        self._result: TestResult | None = None

    def run(self, tests: Any) -> Any:
        runner = unittest.TextTestRunner(self, verbosity=2, resultclass=self._made)
        return runner.run(tests)

    def close(self) -> None:
        self.is_closed = True
        if self._result is not None:
            self._result.stop()

    def write(self, text: str) -> None:
        if not self.is_closed:
            self._stream.write(text)

    def flush(self) -> None:
        if not self.is_closed:
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _made(self, *args: Any, **kwargs: Any) -> TestResult:
        self._result = TestResult(*args, **kwargs)
        if self.is_closed:
            self._result.stop()
        return self._result


@public("launch_testing.test_runner")
class LaunchTestRunner:
    """Runs launches one after the other; `debug` as in LaunchService."""

    def __init__(
        self,
        test_runs: Sequence[TestRun],
        launch_file_arguments: Sequence[str] = (),
        debug: bool = False,
    ) -> None:
        self._test_runs = test_runs
        self._launch_file_arguments = launch_file_arguments
        self._debug = debug

    def generate_preamble(self) -> list[Any]:
        """Entities before the description; for subclasses."""
        return []

    def run(self) -> dict[TestRun, Any]:
        """The results by run; a launch that ends before its tests is the last one."""
        results: dict[TestRun, Any] = {}
        for run in self._test_runs:
            if len(self._test_runs) > 1:
                print(f"\nStarting test run {run}")
            try:
                worker = RunnerWorker(
                    run, self.generate_preamble(), self._launch_file_arguments, self._debug
                )
                results[run] = worker.run()
            except skips() as skipped:
                print(f"{run} is skipped: {skipped}")
                results[run] = SkipResult(run, str(skipped))
            except LaunchDiedError:
                message = "Launch stopped before the active tests finished."
                results[run] = FailResult(run, message)
                break
        return results

    def validate(self) -> None:
        """Raise an Exception if parameters and arguments of a description do not fit."""
        for run in self._test_runs:
            function = inspect.unwrap(run._test_description_function)
            spec = inspect.getfullargspec(function)
            names = [*spec.args, *spec.kwonlyargs]
            for name in run.param_args:
                if name not in names:
                    raise Exception(
                        "Could not find an argument in generate_test_description matching "
                        f"parametrized argument '{name}'"
                    )
            for name in names:
                if name not in run.param_args:
                    raise Exception(
                        f"generate_test_description has unexpected extra argument '{name}'"
                    )
