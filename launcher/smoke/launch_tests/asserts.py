"""Assertions about exit codes and output of processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from launcher.language.naming import public
from launcher.smoke.launch_tests.process_lookup import resolveProcesses
from launcher.smoke.launch_tests.text_matching import build_text_match, without_escapes

EXIT_OK = 0
EXIT_SIGINT = 130
EXIT_SIGQUIT = 131
EXIT_SIGKILL = 137
EXIT_SIGSEGV = 139


def assertExitCodes(
    proc_info: Any,
    allowable_exit_codes: Sequence[int] = (EXIT_OK,),
    process: Any = None,
    cmd_args: Any = None,
    *,
    strict_proc_matching: bool = True,
) -> None:
    """Fail unless these processes, all without `process`, have ended with one of the codes."""
    for code in allowable_exit_codes:
        if not isinstance(code, int):
            raise AssertionError(f"Provided exit code {code} is not an int")
    for action in resolveProcesses(
        proc_info, process=process, cmd_args=cmd_args, strict_proc_matching=strict_proc_matching
    ):
        info = proc_info[action]
        if info.returncode not in allowable_exit_codes:
            raise AssertionError(f"Proc {info.process_name} exited with code {info.returncode}")


def assertInStream(
    proc_output: Any,
    expected_output: Any,
    process: Any,
    cmd_args: Any = None,
    *,
    output_filter: Callable[[str], str] | None = None,
    strict_proc_matching: bool = True,
    strip_ansi_escape_sequences: bool = True,
    stream: str = "stderr",
) -> None:
    """Fail unless one of these processes has written what is expected.

    A text, a compiled pattern, or a sequence of these, in this order. `stream`: stderr or stdout.
    """
    actions = resolveProcesses(
        proc_output, process=process, cmd_args=cmd_args, strict_proc_matching=strict_proc_matching
    )
    if output_filter is not None and not callable(output_filter):
        raise ValueError("output_filter is not callable")
    if stream not in ("stdout", "stderr"):
        raise ValueError("Invalid value for stream; must be 'stdout' or 'stderr'")
    find = build_text_match(expected_output)
    for action in actions:
        text = written(proc_output[action], stream)
        if strip_ansi_escape_sequences:
            text = without_escapes(text)
        if find(text if output_filter is None else output_filter(text)) is not None:
            return
    names = ", ".join(sorted(action.process_details["name"] for action in actions))
    raise AssertionError(
        f"Did not find '{expected_output}' in output for any of the matching processes: {names}"
    )


def written(events: Sequence[Any], stream: str = "") -> str:
    """The text of these events, those of one stream or of both."""
    return "".join(
        event.text.decode(errors="replace")
        for event in events
        if not stream or getattr(event, f"from_{stream}")
    )


def assertInStdout(
    proc_output: Any, expected_output: Any, process: Any, cmd_args: Any = None, **options: Any
) -> None:
    """`assertInStream` of the standard output."""
    assertInStream(proc_output, expected_output, process, cmd_args, **options, stream="stdout")


def assertInStderr(
    proc_output: Any, expected_output: Any, process: Any, cmd_args: Any = None, **options: Any
) -> None:
    """`assertInStream` of the standard error."""
    assertInStream(proc_output, expected_output, process, cmd_args, **options, stream="stderr")


def assertDefaultStream() -> str:
    """The stream that `assertInStream` and `waitFor` search unless they are given one."""
    return "stderr"


@public("launch_testing.asserts.assert_sequential_output")
class SequentialTextChecker:
    """Searches each text after the previous one; a text does not extend over two outputs."""

    def __init__(self, output: Sequence[str]) -> None:
        self._output = output
        self._index = 0  # of the output
        self._position = 0  # in it

    def assertInText(self, msg: str) -> None:
        self.assertInStdout(msg)

    def assertInStdout(self, msg: str) -> None:
        position = self._position
        for index in range(self._index, len(self._output)):
            found = self._output[index].find(msg, position)
            if found >= 0:
                self._index, self._position = index, found + len(msg)
                return
            position = 0
        raise AssertionError(
            f"'{msg}' not found in sequence after previous match.  "
            f"The output near the last matched line:\n{self.get_nearby_lines()}"
        )

    def get_nearby_lines(self) -> str:
        """The line of the last match, with two before and two after it."""
        first = max(0, self._index - 2)
        text = "".join(self._output[first : self._index + 4])
        here = sum(map(len, self._output[first : self._index])) + self._position
        before = "\n".join(text[:here].split("\n")[-3:])
        end = here
        for _ in range(3):
            end = max(text.find("\n", end + 1), end)
        return before + text[here:end]


@contextmanager
def assertSequentialStdout(
    proc_output: Any, process: Any, cmd_args: Any = None
) -> Iterator[SequentialTextChecker]:
    """A checker of the output of one process."""
    (action,) = resolveProcesses(proc_output, process=process, cmd_args=cmd_args)
    yield SequentialTextChecker([written([event]) for event in proc_output[action]])
