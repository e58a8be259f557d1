"""The summary at the end of a run: table, one line, first errors."""

from __future__ import annotations

import re

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.record import replace
from launcher.base.model.spec import ProcessSpec, RestartMode, RestartPolicy, StopPolicy
from launcher.hosts.engine.remote_host import RemoteHost
from launcher.hosts.file.hosts_model import Host
from launcher.posix.spawn import Child
from launcher.run.logs import messages, summary
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import Exited, MachineCommand, ReportExit
from launcher.run.processes.process import Process

STOPPED = ReportExit(Outcome(returncode=-2), asked=True, retry_in_s=None)
DIED = ReportExit(Outcome(returncode=3), asked=False, retry_in_s=None)
OTHER_DEATH = ReportExit(Outcome(returncode=4), asked=False, retry_in_s=None)


def process(
    name: str, end: ReportExit | None = STOPPED, *, deaths: int = 0, starts: int = 1
) -> Process:
    spec = ProcessSpec(name=name, label=name, argv=(name,), env={}, restart=RestartPolicy())
    one = Process(1, spec, number=1, prefix=b"")
    one.last_end = end
    one.history.starts, one.history.deaths, one.history.run_s = starts, deaths, 12.34
    one.history.first_death = Outcome(returncode=3) if deaths else None
    one.history.sampled(31_000_000)
    one.history.sampled(None)
    one.history.sampled(30_000_000)
    return one


class Log:
    """Keeps what is written."""

    def __init__(self) -> None:
        self.screen: list[tuple[str, str]] = []
        self.file: list[tuple[str, str]] = []

    def log(self, level: str, logger: str, text: str, *, sink: str = "") -> None:
        self.screen += [(level, text)] if sink != "log" else []
        self.file += [(level, text)] if sink != "screen" else []


def written(processes: list[Process], *, code: int = 0, columns: int | None = None, **words) -> Log:
    log = Log()
    details = {"causes": [], "end_reason": "", **words}
    summary.write(log, processes, columns=columns, code=code, **details)  # type: ignore[arg-type]
    return log


def test_processes_of_which_none_was_started_have_not_ended_as_expected():
    never = [process("a-1", None, starts=0), process("b-2", None, starts=0)]
    for one in never:
        one.history.run_s = 0.0
    text = summary.all_well(never)
    assert text.startswith("no process was started")
    assert "ended" not in text


def test_what_was_not_started_has_not_ended():
    ended, never = process("a-1"), [process(f"b-{n}", None, starts=0) for n in range(30)]
    ((_, text),) = written([ended, never[0]]).screen
    assert "1 process ended as expected after 12.3 s; 1 process was not started; peak" in text
    died = process("c-3", DIED, deaths=1)
    (_, table), (_, last) = written([died, never[0], never[1]]).screen
    assert re.search(r"b-0 +not started +0 ", table)
    assert last.endswith("restarted or ended as expected; 2 processes were not started")
    (_, table), _ = written([died, ended, *never], code=1).screen
    text = "    and 1 process ended as expected and 30 processes were not started"
    assert table.splitlines()[-1] == text


EXIT = Outcome(returncode=0)


@pytest.mark.parametrize(
    ("deaths", "exits", "end", "text"),
    [
        (0, 2, ReportExit(EXIT, asked=False, retry_in_s=None), "exited 3x: exit code 0"),
        (0, 2, ReportExit(EXIT, asked=False, retry_in_s=1.0), "exited 2x: exit code 0"),
        (0, 1, ReportExit(EXIT, asked=False, retry_in_s=1.0), "exit code 0"),
        (0, 2, STOPPED, "exited 2x (exit code 0), then stopped (SIGINT)"),
        (1, 2, DIED, "exited 2x (exit code 0), then exit code 3"),
        (2, 1, DIED, "exited 1x (exit code 0), then died 2x: exit code 3"),
        (2, 1, STOPPED, "died 2x (exit code 3), exited 1x (exit code 0), then stopped (SIGINT)"),
        (
            1,
            0,
            ReportExit(EXIT, asked=False, retry_in_s=None),
            "died 1x (exit code 3), then exit code 0",
        ),
        (1, 0, DIED, "exit code 3"),
        (2, 0, DIED, "died 2x: exit code 3"),
        (2, 0, OTHER_DEATH, "died 1x (exit code 3), then exit code 4"),
    ],
)
def test_deaths_and_clean_exits_are_told_apart(deaths: int, exits: int, end: ReportExit, text: str):
    one = process("a-1", end, deaths=deaths, starts=4)
    one.history.exits = exits
    (_, table), _ = written([one]).screen
    assert table.splitlines()[2].removeprefix("    a-1      ").partition("   ")[0] == text


@pytest.mark.parametrize(("mode", "code"), [("always", 0), ("on-failure", 3)])
def test_used_up_restarts_are_named(mode: str, code: int):
    one = process("a-1")
    one.machine = ProcessMachine(
        RestartPolicy(mode=RestartMode(mode), max_restarts=1), StopPolicy()
    )
    for command in (MachineCommand.START, MachineCommand.TICK):
        one.machine.handle(command, 0.0)
        one.machine.handle(MachineCommand.STARTED, 0.0)
        (one.last_end,) = one.machine.handle(Exited(Outcome(returncode=code)), 0.0)
    one.history.deaths, one.history.exits = (2, 0) if code else (0, 1)
    one.history.first_death = Outcome(returncode=3)
    (_, table), _ = written([one]).screen
    how = "died 2x: exit code 3" if code else "exited 2x: exit code 0"
    assert f"{how}, restarts used up" in table
    line = messages.restarts_used_up(one.machine)
    assert (line.level, line.text) == (
        ("ERROR", "process is given up after 1 restart")
        if code
        else ("INFO", "process is not restarted again after 1 restart")
    )


def test_where_all_is_well_it_is_one_line():
    log = written([process("a-1"), process("b-2")], end_reason="ctrl-c (SIGINT)")
    assert log.screen == [
        (
            "INFO",
            "exit code 0: 2 processes ended as expected after 12.3 s; "
            "peak memory 31.0 MB USS (b-2); ended by: ctrl-c (SIGINT)",
        )
    ]
    assert written([]).screen == []
    assert written([process("a-1")], is_script=True).screen == []


def test_unusual_exit_codes_after_a_stop_are_named():
    odd = [process(f"sh-{n}") for n in range(5)]
    for one, code in zip(odd, (7, 139, -27, 99, 3), strict=True):
        one.history.odd_code = code
    ((_, text),) = written([process("a-1"), odd[0]]).screen
    assert text.startswith(
        "exit code 0: 1 process ended as expected after 12.3 s; "
        "stopped with an unusual exit code: sh-0 (7); peak memory"
    )
    ((_, text),) = written(odd).screen
    many = (
        "stopped with unusual exit codes: sh-0 (7), sh-1 (139, SIGSEGV), sh-2 (SIGPROF) and 2 more"
    )
    assert text == f"exit code 0: {many}; peak memory 31.0 MB USS (sh-4)"
    died = process("b-2", DIED, deaths=1)
    *_, (_, text) = written([died, odd[0]], code=1, causes=["b-2 ended unexpectedly"]).screen
    assert text == (
        "exit code 1: b-2 ended unexpectedly; stopped with an unusual exit code: sh-0 (7)"
    )


def test_a_crash_in_answer_to_a_stop_is_in_the_table():
    crashed = ReportExit(Outcome(returncode=-11), asked=False, retry_in_s=None, crashed=True)
    one = process("a-1", crashed, deaths=1)
    (_, table), _ = written([one], code=1).screen
    assert re.search(r"a-1 +SIGSEGV when it was stopped ", table)


def test_processes_that_were_left_on_other_hosts_have_not_ended():
    left = process("robot-3", None)
    left.host = RemoteHost(Host(name="bot1", address="10.0.0.2"))
    left.is_abandoned = True
    ((_, text),) = written([process("a-1"), left]).screen
    assert "1 process ended as expected after 12.3 s; 1 process left on other hosts" in text
    ((_, text),) = written([left]).screen
    assert text.startswith("exit code 0: 1 process left on other hosts")
    (_, table), _ = written([process("a-1", DIED, deaths=1), left], code=1).screen
    assert "robot-3  left on bot1" in table


def test_a_start_that_failed_is_no_death():
    refused = ReportExit(Outcome(spawn_errno=2, spawn_what="x"), asked=False, retry_in_s=None)
    one, two = process("a-1", refused, deaths=1), process("b-2", refused)
    one.history.refusals, two.history.refusals = 2, 3
    (_, table), _ = written([one, two], code=1).screen
    row, other = table.splitlines()[2:]
    assert "died 1x (exit code 3), then could not be started: x: No such file" in row
    assert "  could not be started: x: No such file" in other


def test_what_had_ended_before_its_run_was_attached_to_was_started():
    (_, table), _ = written([process("a-1", None, starts=3), process("b-2", DIED, deaths=1)]).screen
    assert re.search(r"a-1 +had ended before +2 ", table)
    ((_, text),) = written([process("a-1", None, starts=3), process("b-2")]).screen
    assert "1 process ended as expected after 12.3 s; 1 process had ended before" in text


def test_the_time_of_a_process_that_runs_on_counts():
    left = process("robot-3", None)
    left.child, left.machine.running_since = Child(7, {}, -1, -1, -1), 5.0
    left.abandon(9.0)
    assert (left.is_abandoned, left.history.run_s) == (True, pytest.approx(12.34 + 4))


def test_a_cause_that_ended_the_run_is_told_once():
    reason = "exception in the launch file"
    log = written([process("a-1")], code=1, causes=[reason], end_reason=reason)
    assert log.screen == [("ERROR", f"exit code 1: {reason}")]


def test_otherwise_a_table_then_the_exit_code_and_why():
    died = process("robot_1-1", DIED, deaths=1)
    died.history.first_error = "cannot open /dev/ttyUSB0"
    log = written([died, process("s-2")], code=1, causes=["robot_1-1 ended unexpectedly"])
    (level, text), last = log.screen
    assert (level, last) == ("ERROR", ("ERROR", "exit code 1: robot_1-1 ended unexpectedly"))
    assert text.splitlines() == [
        "processes of this run:",
        "    PROCESS    ENDED             RESTARTS  RUN TIME  PEAK USS  FIRST ERROR",
        "    robot_1-1  exit code 3              0    12.3 s   31.0 MB  cannot open /dev/ttyUSB0",
        "    s-2        stopped (SIGINT)         0    12.3 s   31.0 MB",
    ]
    assert len(written([died], code=1, is_script=True).screen) == 1


def test_of_a_test_the_table_is_only_in_the_log_file():
    died = process("robot_1-1", DIED, deaths=1)
    log = written([died], code=1, is_script=True, sink="log")
    assert (log.screen, len(log.file)) == ([], 1)


def test_a_process_that_was_restarted_is_in_a_table_even_if_the_exit_code_is_0():
    log = written([process("a-1", deaths=4, starts=5), process("b-2")])
    (level, text), (_, last) = log.screen
    assert level == "INFO"
    row = next(line for line in text.splitlines() if "a-1" in line)
    assert row.split("  ")[2:3] == ["a-1"]
    assert "died 4x (exit code 3), then stopped (SIGINT)         4 " in row
    assert last == "exit code 0: every process was restarted or ended as expected"


@pytest.mark.parametrize("columns", [80, 120])
def test_it_fits_the_terminal_and_is_whole_in_the_file(columns: int):
    one = process("a_process_with_a_very_long_name_indeed_1-1", DIED, deaths=4, starts=5)
    one.history.first_error = "x" * 200
    log = written([one], code=1, columns=columns)
    (_, text), _ = log.screen
    assert max(map(len, text.splitlines())) <= columns
    assert ("first error: xxx" in text) == (columns == 80)
    assert "1-1  died 4x: exit code 3 " in text
    (_, whole), _ = log.file
    assert one.name in whole and "x" * 200 in whole


def test_of_a_hundred_processes_those_in_trouble_are_listed():
    many = [process(f"p-{number}", deaths=number % 50 == 0) for number in range(100)]
    (_, text), _ = written(many, code=1, columns=80).screen
    lines = text.splitlines()
    assert [line.split()[0] for line in lines[2:4]] == ["p-0", "p-50"]
    assert lines[4:] == ["    and 98 processes ended as expected"]
    bad = [process(f"p-{number}", DIED, deaths=1) for number in range(100)]
    (_, text), _ = written(bad, code=1).screen
    assert len(text.splitlines()) == summary.MAX_ROWS + 3
    assert text.endswith("\n    and 80 processes did not; see events.jsonl")


def test_the_stack_of_what_hung_when_it_ended_is_told_unless_all_is_well():
    hung, well = process("a-1", DIED, deaths=1), process("b-2")
    hung.history.hang = well.history.hang = ("a-1 had not responded", "pid 7: a", "  f (a:1)")
    _, (_, stack), _ = written([hung, well], code=1).screen
    assert stack == "a-1 had not responded\n    pid 7: a\n      f (a:1)"
    assert len(written([well]).screen) == 1


def test_what_had_to_be_killed_or_never_started_is_told():
    killed = process("a-1", ReportExit(Outcome(returncode=-9), asked=True, retry_in_s=None))
    for event in (
        MachineCommand.START,
        MachineCommand.STARTED,
        MachineCommand.STOP,
        *[MachineCommand.SKIP_GRACE] * 2,
    ):
        killed.machine.handle(event, 0.0)
    lines = summary.table([killed, process("b-2", None, starts=0)], None)
    assert "had to be killed (SIGKILL)" in lines[1]
    assert "not started" in lines[2]


@pytest.mark.parametrize(
    ("output", "error"),
    [
        (b"fine\n", ""),
        (b"\x1b[31m[ERROR] [176.5] [node]: no port\x1b[0m\n[FATAL] [1.0] [n]: x\n", "no port"),
        (b"\r10%\r20%[ERROR] [1.0] [bar]: no port\n", "no port"),
        (b"ERROR:root:no\tport\n", "ERROR:root:no port"),
        (b"Traceback (most recent call last):\n  File 'x'\nValueError: 3\n", "ValueError: 3"),
        (b"Traceback (most recent call last):\n  File 'x'\nKeyboardInterrupt\n", ""),
        (b"a \xff\n[ERROR] [1.0] [n]: \xff\n", "\ufffd"),
    ],
)
def test_the_first_error_is_found_in_the_output(output: bytes, error: str):
    one = process("a-1")
    one.ring.append("both", 1.0, b"[ERROR] [0.5] [n]: of an earlier life\n")
    one.ring.append("both", 5.0, output)
    assert summary.first_error(one, 2.0) == error


TRACEBACK = b"Traceback (most recent call last):\n  File 'x'\n    raise\nValueError: 3\n"


@pytest.mark.parametrize("cut", range(1, 4))
def test_a_traceback_may_come_in_several_reads_between_lines_of_the_other_stream(cut: int):
    one = process("a-1")
    lines = TRACEBACK.splitlines(keepends=True)
    one.ring.append("stderr", 1.0, b"".join(lines[:cut]))
    one.ring.append("stdout", 2.0, b"[ERROR] [1.0] [n]: later\n")
    one.ring.append("stderr", 3.0, b"".join(lines[cut:]))
    assert summary.first_error(one) == "ValueError: 3"
    one.ring.append("stderr", 4.0, b"ERROR: of the next life\n")
    assert summary.first_error(one, 4.0) == "ERROR: of the next life"


def test_the_first_error_is_that_which_began_first_in_any_stream():
    one = process("a-1")
    one.ring.append("stderr", 1.0, b"fine\n")
    one.ring.append("stdout", 2.0, b"ERROR: one\n")
    one.ring.append("stderr", 3.0, b"ERROR: two\n")
    assert summary.first_error(one) == "ERROR: one"


def test_the_exception_of_a_logged_traceback_is_found():
    one = process("a-1")
    one.ring.append("both", 1.0, b"[ERROR] [1.0] [n]: " + TRACEBACK)
    assert summary.first_error(one) == "ValueError: 3"


@pytest.mark.parametrize(
    ("lines", "text"),
    [
        ([1], "1 line of p0 is only in its log; output='screen' shows it"),
        ([3], "3 lines of p0 are only in its log; output='screen' shows them"),
        ([1, 2], "1 line of p0 and 2 of p1 are only in their logs; output='screen' shows them"),
        (
            [5, 4, 3, 2, 1],
            "5 lines of p0, 4 of p1, 3 of p2 and those of 2 more are only in their logs; "
            "output='screen' shows them",
        ),
    ],
)
def test_lines_that_were_not_shown_are_counted(lines: list[int], text: str):
    found = [process(f"p{number}") for number in range(len(lines))]
    for one, number in zip(found, lines, strict=True):
        one.spec = replace(one.spec, chooses_output=False)
        one.history.unshown_lines = number
    assert list(summary.unshown(found, has_logs=True)) == [text]
    (without,) = summary.unshown(found, has_logs=False)
    assert without == re.sub("only in (its log|their logs)", "not shown", text)


def test_what_the_launch_file_has_chosen_not_to_show_is_not_told():
    chosen, silent = process("a"), process("b")
    chosen.history.unshown_lines = 3
    silent.spec = replace(silent.spec, chooses_output=False)
    assert list(summary.unshown([chosen, silent], has_logs=True)) == []
