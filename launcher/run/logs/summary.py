"""The summary at the end of a run: a table of its processes, the exit code and why.

Where all is well it is one line.
"""

from __future__ import annotations

import bisect
import itertools
import re
import signal
from collections.abc import Collection, Iterable, Iterator, Sequence

from launcher.base.model.events import SIGNALLED, signal_name
from launcher.base.text import count, several
from launcher.output.filters import ERROR, level_of
from launcher.output.lines import for_terminal, without_colour
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.output.stdout import StdoutWriter
    from launcher.run.ending.shutdown import Shutdown
    from launcher.run.logs.run_log import RunLog
    from launcher.run.processes.machine_events import ReportExit
    from launcher.run.processes.process import History

MAX_ROWS = 20  # beyond it, processes that ended as expected are only counted
MAX_NAME = 24  # columns of a name on a terminal
MIN_ENDED = 20
FIGURES = 30  # columns of restarts, time and memory with their gaps
MIN_ERROR = 24  # columns for the first error; with fewer it is on a separate line
ERROR_CHARS = 300  # where there is no terminal
MAX_UNSHOWN = 3  # processes
MAX_HANGS, MAX_STACK = 3, 40  # processes, and lines of each
MAX_NAMES = 3  # of processes with unusual exit codes
INDENT = "    "
GAP = "  "
_HEAD = ("PROCESS", "ENDED", "RESTARTS", "RUN TIME", "PEAK USS", "FIRST ERROR")
_RIGHT = (2, 3, 4)  # columns that are aligned to the right

_TRACEBACK = b"Traceback (most recent call last):"
_WORDS = re.compile(rb"ERROR|FATAL|CRITICAL|" + re.escape(_TRACEBACK))
_HEAD_OF_ROS = re.compile(rb"\[\w+\] \[[\d.]+\] \[[^\]]*\]: ")
_OF_A_STOP = re.compile(rb"(?:\w+\.)*(KeyboardInterrupt|ExternalShutdownException)\b")


def conclude(
    log: RunLog,
    screen: StdoutWriter,
    processes: Sequence[Process],
    shutdown: Shutdown,
    *,
    code: int,
    has_exception: bool,
    is_script: bool,
    is_test: bool,
) -> None:
    """Write the last lines of a run: what the screen lacks, the first failure, the summary.

    A test (`is_test`) says which exits it expects, so what is unexpected is only in `launch.log`.
    """
    sink = "log" if is_test else ""
    dropped_lines = screen.settle(is_interrupted=shutdown.machine.stop_signal is not None)
    if dropped_lines:
        text = f"the terminal is slow: {dropped_lines} lines dropped"
        log.log("WARNING", "launch", text)
    if shutdown.machine.first_failure is not None:
        log.log("ERROR", "launch", shutdown.machine.first_failure, sink=sink)
        from launcher.run.logs.lacking_rclpy import lacking  # only for failures

        if found := lacking(processes):
            log.log("WARNING", "launch", found)
    for text in unshown(processes, has_logs=log.has_files):
        log.log("INFO", "launch", text)
    write(
        log,
        processes,
        columns=screen.columns,
        code=code,
        causes=["exception in the launch file"] * has_exception + shutdown.causes(),
        end_reason=shutdown.machine.end_reason,
        is_script=is_script,
        sink=sink,
    )


def unshown(processes: Iterable[Process], *, has_logs: bool) -> Iterator[str]:
    """That lines were not on the screen, since the launch file does not say where they go."""
    found = [one for one in processes if one.history.unshown_lines and not one.spec.chooses_output]
    if not found:
        return
    parts = [f"{one.history.unshown_lines} of {one.name}" for one in found[:MAX_UNSHOWN]]
    number, _, rest = parts[0].partition(" ")
    parts[0] = f"{count(int(number), 'line')} {rest}"
    more = len(found) - MAX_UNSHOWN
    parts += [f"those of {more} more"] if more > 0 else []
    *before, last = parts
    listed = f"{', '.join(before)} and {last}" if before else last
    verb, them = ("is", "it") if listed.startswith("1 line of") and not before else ("are", "them")
    where = f"only in {'their logs' if before else 'its log'}" if has_logs else "not shown"
    yield f"{listed} {verb} {where}; output='screen' shows {them}"


def write(
    log: RunLog,
    processes: Sequence[Process],
    *,
    columns: int | None,
    code: int,
    causes: Sequence[str],
    end_reason: str,
    is_script: bool = False,
    sink: str = "",
) -> None:
    """Write the summary to the screen and to `launch.log`; `causes` explain a code other than 0.

    A script (`is_script`) chooses its exit code, which is not known. `sink`: one of the two.
    """
    if not processes and not code:
        return
    level = "ERROR" if code else "INFO"
    if not all(map(is_well, processes)):
        for where, width in (("screen", columns), ("log", None)):
            if sink in (where, ""):
                text = "\n".join(["processes of this run:", *table(processes, width)])
                log.log(level, "launch", text, sink=where)
        for text in hangs(processes):
            log.log(level, "launch", text, sink=sink)
        well = "every process was restarted or ended as expected"
        causes = causes or ["; ".join([well, *_not_started(processes)])]
    if is_script:
        return
    found = [*causes, *odd_codes(processes)] if causes or not processes else [all_well(processes)]
    text = f"exit code {code}: {'; '.join(found)}"
    ended = f"; ended by: {end_reason}" if end_reason and end_reason not in causes else ""
    log.log(level, "launch", text + ended)


def is_well(process: Process) -> bool:
    """Whether it ended as expected, and never had to be restarted."""
    history = process.history
    troubles = history.deaths or history.exits or history.refusals
    return not (troubles or process.machine.had_to_be_killed)


def all_well(processes: Collection[Process]) -> str:
    """`5 processes ended as expected after 12.3 s; peak memory 31.0 MB USS (robot_1-3)`."""
    left = [process for process in processes if process.is_abandoned]
    started = [one for one in processes if one.history.starts and not one.is_abandoned]
    before = [process for process in started if _had_ended_before(process)]
    odd = [process for process in started if process.history.odd_code is not None]
    ended = [process for process in started if process not in [*before, *odd]]
    longest_s = max((process.history.run_s for process in ended), default=0.0)
    parts = [f"{count(len(ended), 'process')} ended as expected after {longest_s:.1f} s"]
    parts = parts if ended else []
    parts += [f"{count(len(before), 'process')} had ended before"] if before else []
    parts += [f"{count(len(left), 'process')} left on other hosts"] if left else []
    parts += [*odd_codes(processes), *_not_started(processes)]
    text = "; ".join(parts) if started or left else "no process was started"
    peaks = [(p.history.peak_uss, p.name) for p in processes if p.history.peak_uss is not None]
    if not peaks:
        return text
    size, name = max(peaks)
    return f"{text}; peak memory {_megabytes(size)} USS ({name})"


def odd_codes(processes: Collection[Process]) -> list[str]:
    """`stopped with unusual exit codes: sh-1 (7), sh-2 (139, SIGSEGV)`, if any was."""
    codes = {one.name: one.history.odd_code for one in processes if one.history.odd_code}
    if not codes:
        return []
    named = [f"{name} ({_code(code)})" for name, code in codes.items()]
    an, s = ("an ", "") if len(named) == 1 else ("", "s")
    return [f"stopped with {an}unusual exit code{s}: {several(named, MAX_NAMES)}"]


def _code(code: int) -> str:
    """A signal by its name, and the exit code by which a shell reports one, with that."""
    if code < 0:
        return signal_name(-code)
    signum = code - SIGNALLED
    return f"{code}, {signal_name(signum)}" if 0 < signum < signal.NSIG else str(code)


def _not_started(processes: Iterable[Process]) -> list[str]:
    """`1 process was not started`, if that is so."""
    number = sum(not (one.history.starts or one.is_abandoned) for one in processes)
    verb = "was" if number == 1 else "were"
    return [f"{count(number, 'process')} {verb} not started"] if number else []


def hangs(processes: Sequence[Process]) -> list[str]:
    """The stacks of processes whose nodes did not answer when they were ended, or died."""
    found = [process.history.hang for process in processes if not is_well(process)]
    shown = [hang for hang in found if hang][:MAX_HANGS]
    return [
        "\n".join([head, *(f"{INDENT}{line}" for line in stack[:MAX_STACK])])
        for head, *stack in shown
    ]


def _had_ended_before(process: Process) -> bool:
    """In a run that was attached to later."""
    is_over = process.last_end is None and not process.is_abandoned
    return is_over and process.history.starts > 0


def table(processes: Sequence[Process], columns: int | None) -> list[str]:
    """The lines of the table, at most `columns` wide; None: as wide as they are."""
    troubled = [process for process in processes if not is_well(process)]
    shown = list(processes) if len(processes) <= MAX_ROWS else troubled[:MAX_ROWS]
    rows = [_cells(process) for process in shown]
    if columns is not None:
        rows = _narrowed(rows, columns)
    widths = [max(map(len, column)) for column in zip(_HEAD[:-1], *rows, strict=True)]
    room = None if columns is None else columns - len(INDENT) - sum(widths) - len(GAP) * len(widths)
    errors = [process.history.first_error or first_error(process) for process in shown]
    in_row = room is None or room >= MIN_ERROR
    head = _HEAD if in_row and any(errors) else _HEAD[:-1]
    lines = [_aligned(head, widths)]
    for row, error in zip(rows, errors, strict=True):
        lines += _row(row, error, widths, room if in_row else None, columns, in_row=in_row)
    omitted = [process for process in processes if process not in shown]
    return [*lines, *_omitted(omitted)]


def _row(
    row: Sequence[str],
    error: str,
    widths: Sequence[int],
    room: int | None,
    columns: int | None,
    *,
    in_row: bool,
) -> list[str]:
    if not error:
        return [_aligned(row, widths)]
    if in_row:
        return [_aligned([*row, _cut(error, room or ERROR_CHARS)], widths)]
    below = f"{INDENT * 2}first error: {error}"
    return [_aligned(row, widths), _cut(below, columns or ERROR_CHARS)]


def _omitted(processes: Sequence[Process]) -> list[str]:
    troubled = sum(not is_well(process) for process in processes)
    well = [process for process in processes if is_well(process)]
    ended = sum(process.history.starts > 0 for process in well)
    parts = [f"{count(ended, 'process')} ended as expected"] if ended else []
    parts += _not_started(well)
    parts += [f"{count(troubled, 'process')} did not; see events.jsonl"] if troubled else []
    return [f"{INDENT}and {' and '.join(parts)}"] if parts else []


def _narrowed(rows: Sequence[tuple[str, ...]], columns: int) -> list[tuple[str, ...]]:
    """The rows with shorter names and ends, so that the figures fit."""
    rows = [(_middle_cut(name, MAX_NAME), *others) for name, *others in rows]
    room = columns - len(INDENT) - max(len(row[0]) for row in rows) - len(GAP) - FIGURES
    return [(name, _cut(end, max(MIN_ENDED, room)), *figures) for name, end, *figures in rows]


def _cells(process: Process) -> tuple[str, ...]:
    history = process.history
    peak = "-" if history.peak_uss is None else _megabytes(history.peak_uss)
    restarts = str(max(0, history.starts - 1))
    return process.name, _ended(process), restarts, f"{history.run_s:.1f} s", peak


def _ended(process: Process) -> str:
    """As `_how_it_ended`; for one that is in trouble, with its host: `exit code 1 on bot1`."""
    text, host = _how_it_ended(process), process.host_name
    is_named = not host or is_well(process) or text.endswith(f" {host}")
    return text if is_named else f"{text} on {host}"


def _how_it_ended(process: Process) -> str:
    """`stopped (SIGINT)`, `died 4x: exit code 1`, `died 4x (exit code 1), then exit code 0`."""
    end = process.last_end
    if process.is_abandoned:
        return f"left on {process.host_name}"
    if process.machine.is_stuck:
        return "still exists after SIGKILL"
    if _had_ended_before(process):
        return "had ended before"
    if end is None:
        return "not started"
    text = f"{end.outcome} when it was stopped" if end.crashed else str(end.outcome)
    if process.machine.had_to_be_killed:
        text = f"had to be killed ({text})"
    elif end.asked:
        text = f"stopped ({text})"
    is_used_up = process.machine.has_used_up_restarts and end.outcome.returncode is not None
    return _with_earlier(process.history, end, text) + ", restarts used up" * is_used_up


def _with_earlier(history: History, end: ReportExit, text: str) -> str:
    """The last end, which `text` describes, with those before it."""
    code = None if end.asked else end.outcome.returncode
    exits = history.exits - (code == 0 and end.retry_in_s is not None)
    deaths = history.deaths - (code is not None and end.outcome.failed)
    how = str(history.first_death)
    earlier = []
    if deaths and code and how == text:
        text = f"died {deaths + 1}x: {text}"
    elif deaths:
        earlier.append(f"died {deaths}x ({how})")
    if exits and code == 0:
        text = f"exited {exits + 1}x: {text}"
    elif exits:
        earlier.append(f"exited {exits}x (exit code 0)")
    return f"{', '.join(earlier)}, then {text}" if earlier else text


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"


def _aligned(cells: Sequence[str], widths: Sequence[int]) -> str:
    texts = [
        cell.rjust(width) if place in _RIGHT else cell.ljust(width)
        for place, (cell, width) in enumerate(zip(cells, widths, strict=False))
    ]
    return (INDENT + GAP.join([*texts, *cells[len(widths) :]])).rstrip()


def _cut(text: str, columns: int) -> str:
    return text if len(text) <= columns else f"{text[: columns - 3]}..."


def _middle_cut(name: str, columns: int) -> str:
    """The name cut in its middle: its end, a number, distinguishes it from others."""
    if len(name) <= columns:
        return name
    start = columns // 2
    return f"{name[: start - 3]}...{name[start - columns :]}"


# ---- the first error


def first_error(process: Process, since_s: float = 0.0) -> str:
    """The first line of level ERROR, or the exception of a traceback, in its kept output."""
    streams: dict[str, list[tuple[int, bytes]]] = {}
    for number, block in enumerate(process.ring.last(1_000_000)):
        if block.read_at_s >= since_s:
            streams.setdefault(block.stream, []).append((number, block.lines))
    found = [error for pieces in streams.values() for error in _first(pieces)]
    if not found:
        return ""
    _, error = min(found)
    return error.decode(errors="replace").replace("\t", " ").strip()


def _first(pieces: Sequence[tuple[int, bytes]]) -> Iterator[tuple[int, bytes]]:
    """The first error of a stream, if it has one, with the number of the piece where it begins.

    A read may end between the lines of a traceback.
    """
    starts = list(itertools.accumulate((len(lines) for _, lines in pieces), initial=0))
    for start, error in _errors(b"".join(lines for _, lines in pieces)):
        yield pieces[bisect.bisect(starts, start) - 1][0], error
        return


def _errors(lines: bytes) -> Iterator[tuple[int, bytes]]:
    """The offset and text of each error; only lines with one of the words are looked at."""
    end = 0
    for word in _WORDS.finditer(lines):
        if word.start() < end:
            continue  # in a line with another one
        start = lines.rfind(b"\n", 0, word.start()) + 1
        line, end = _line_at(lines, start)
        head = _HEAD_OF_ROS.search(line)
        text = line[head.end() :] if head else line
        if text.startswith(_TRACEBACK):
            exception = _exception(lines, end) or text
            if not _OF_A_STOP.match(exception):
                yield start, exception
        elif (level_of(line) or 0) >= ERROR:
            yield start, text


def _exception(lines: bytes, at: int) -> bytes:
    """The first line from here on that is not indented."""
    while at < len(lines):
        line, at = _line_at(lines, at)
        if line[:1].strip():
            return line
    return b""


def _line_at(lines: bytes, start: int) -> tuple[bytes, int]:
    """The line that starts here, as a terminal shows it, and the start of the next one."""
    end = lines.find(b"\n", start)
    end = len(lines) if end < 0 else end
    return without_colour(for_terminal(lines[start:end])), end + 1
