"""Every way in which a run ends: no process is left."""

from __future__ import annotations

import os
import re
import shlex
import signal

import psutil
import pytest

from tests.support.benches import MARK, Bench, ControlBench
from tests.support.children import children_with
from tests.support.controlled_run import state_of
from tests.support.terminal import Terminal, marked_processes
from tests.support.waiting import wait_until

STUBBORN = "trap '' INT TERM; echo ready; while :; do sleep 0.1; done"


def test_ctrl_c_reaches_each_child_exactly_once(bench: Bench):
    script = "trap 'echo got INT; exit 0' INT; echo ready; while :; do sleep 0.05; done"
    terminal = bench.terminal(f'sh("{script}"), sh("{script}")')
    terminal.wait_for_all("[sh-1]", "[sh-2]")
    wait_until(lambda: _seen(terminal, "ready", 2), "both are ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert terminal.text.count("got INT") == 2
    order = re.findall(r"sending signal 'SIGINT' to process\[sh-(\d)\]", terminal.text)
    assert order == ["2", "1"]


def _seen(terminal, text: str, times: int) -> bool:
    if terminal.text.count(text) < times:
        terminal.wait_for(text)
    return terminal.text.count(text) >= times


def test_a_child_that_ignores_everything_is_killed_after_its_timeouts(bench: Bench):
    terminal = bench.terminal(
        f'sh("{STUBBORN}", sigterm_timeout="0.3", sigkill_timeout="0.2")',
    )
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130
    assert re.search(r"failed to terminate '0.3' seconds after receiving 'SIGINT'", terminal.text)
    assert "escalating to 'SIGKILL'" in terminal.text
    assert bench.survivors() == []


def test_each_further_ctrl_c_takes_the_next_step_at_once(bench: Bench):
    patience = 'sigterm_timeout="600", sigkill_timeout="600"'
    terminal = bench.terminal(f'sh("{STUBBORN}", {patience})')
    terminal.wait_for("ready")
    terminal.ctrl_c()
    terminal.wait_for("sending signal 'SIGINT'")
    terminal.ctrl_c()
    terminal.wait_for("sending signal 'SIGTERM'")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130
    assert bench.survivors() == []


# What a spawner and the node after it look like; the second must not start when all is to stop.
AFTER = (
    '(first := sh("echo ready; exec sleep 1000", name="first")),'
    "RegisterEventHandler(OnProcessExit("
    'target_action=first, on_exit=[sh("exec sleep 1000", name="next")])),'
    "RegisterEventHandler(OnShutdown(on_shutdown=lambda event, context: "
    '[LogInfo(msg="told: " + event.reason)])),'
)
DYING = 'sh("sleep 0.3; exit 1", name="dying")'


@pytest.mark.parametrize(
    ("words", "told", "code"),
    [
        (["--timeout", "0.5"], "timeout of 0.5 s reached", 0),
        (["--stop-after-quiet", "0.5"], "no output for 0.5 s", 0),
        (["--required", "dying"], "dying-2 is required and has exited", 1),
        (["--exit-when-any-dies"], "dying-2 died", 1),
    ],
)
def test_nothing_more_starts_whatever_ends_the_run(
    bench: Bench, words: list[str], told: str, code: int
):
    done = bench.run(AFTER + (DYING if code else ""), *words)
    assert done.returncode == code
    assert f"told: {told}\n" in done.stdout.decode()
    assert b"next" not in done.stdout
    assert bench.survivors() == []


@pytest.mark.thorough
def test_each_line_begins_the_time_of_a_quiet_run_again(bench: Bench):
    busy = "for i in $(seq 50); do echo line; sleep 0.1; done; exec sleep 60"
    done = bench.run(f'sh("{busy}")', "--stop-after-quiet", "4")
    assert done.returncode == 0
    assert done.stdout.count(b"line\n") == 50
    assert b"ended by: no output for 4 s" in done.stdout


def test_nothing_more_starts_when_a_person_ends_the_run(bench: Bench):
    terminal = bench.terminal(AFTER)
    terminal.wait_for("ready")
    bench.ask_run(terminal.pid, "quit")
    assert terminal.exit_code() == 0
    assert "told: quit requested by a user" in terminal.text
    assert "next" not in terminal.text
    assert bench.survivors() == []


def test_a_stop_names_the_processes_it_waits_for(bench: Bench):
    terminal = bench.terminal(f'sh("{STUBBORN}", sigterm_timeout="1.5", sigkill_timeout="0.1")')
    terminal.wait_for("ready")
    terminal.ctrl_c()
    terminal.wait_for("still waiting for sh-1 (SIGTERM in 0.")
    assert terminal.exit_code() == 130


GRANDCHILDREN = (
    "sleep 1000 & setsid -f sleep 1001; sh -c 'sleep 1002 & sleep 1003' & echo ready; wait"
)


def test_grandchildren_and_daemons_end_with_the_run(bench: Bench):
    terminal = bench.terminal(f'sh("{GRANDCHILDREN}")')
    terminal.wait_for("ready")
    wait_until(lambda: _sleeps(bench) == 4, "all four sleep")
    terminal.ctrl_c()
    terminal.exit_code()
    assert bench.survivors() == []


def test_grandchildren_and_daemons_end_with_a_killed_launcher(bench: Bench):
    terminal = bench.terminal(f'sh("{GRANDCHILDREN}"), sh("{STUBBORN}")')
    terminal.wait_for_all("ready")
    wait_until(lambda: _sleeps(bench) >= 4, "all four sleep")
    terminal.kill()
    wait_until(lambda: bench.survivors() == [], "nothing is left")


def _sleeps(bench: Bench) -> int:
    return sum(line.startswith("sleep 100") for line in bench.survivors())


def test_a_daemon_of_a_process_that_ended_by_itself_ends_with_the_run(bench: Bench):
    done = bench.run('sh("setsid -f sleep 1000 >/dev/null 2>&1")')
    assert done.returncode == 0
    # It may be caught before it has become `sleep`.
    assert re.search(rb"stopping leftover processes: (sleep|setsid) \[\d+\]", done.stdout)
    assert bench.survivors() == []


def test_a_process_that_stopped_itself_hears_of_the_stop_and_so_does_its_child(bench: Bench):
    clean = "trap 'echo cleaned up; exit 0' INT; kill -STOP $$; sleep 1000 & wait"
    (bench.folder / "leader.sh").write_text(clean)
    (bench.folder / "child.sh").write_text(
        f"trap 'exit 0' INT; sh {bench.folder}/leader.sh; exit 0"
    )
    terminal = bench.terminal(
        f'sh("exec sh {bench.folder}/leader.sh", name="leader"), '
        f'sh("exec sh {bench.folder}/child.sh", name="child")'
    )
    wait_until(lambda: _stopped(bench) == 2, "both stand still")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert terminal.text.count("cleaned up") == 2
    assert bench.survivors() == []


def _stopped(bench: Bench) -> int:
    processes = marked_processes(MARK, bench.mark).values()
    return sum(state_of(process.pid) == psutil.STATUS_STOPPED for process in processes)


def test_a_launcher_that_was_started_in_the_background_obeys_sigint(bench: Bench):
    # A script's shell ignores SIGINT for what it starts with `&`, and children inherit that.
    words = shlex.join(bench.command('sh("echo ready; exec sleep 1000")'))
    script = f"{words} & echo launcher $! is there; wait $!; echo exit code $?"
    with Terminal(["sh", "-c", script], env=bench.env) as shell:
        shell.wait_for_all("ready", " is there")
        os.kill(int(re.findall(r"launcher (\d+)", shell.text)[0]), signal.SIGINT)
        # The launcher writes "exit code 0: ..." itself before it exits.
        assert shell.exit_code() == 0
        assert "\nexit code 0\n" in shell.text
    assert bench.survivors() == []


def test_a_reader_that_goes_away_ends_the_run_in_order_and_without_a_word(bench: Bench):
    process = bench.start(AFTER + 'sh("while :; do echo line; sleep 0.01; done")')
    assert process.stdout is not None and process.stderr is not None
    process.stdout.readline()
    process.stdout.close()
    assert process.wait(timeout=60) == 0
    assert process.stderr.read() == b""
    assert bench.survivors() == []


def test_a_closed_terminal_that_is_noticed_by_its_output_first_is_no_second_interrupt(
    bench: Bench,
):
    log, asked, done = (bench.folder / name for name in ("log/latest/launch.log", "asked", "done"))
    script = (
        f"trap 'touch {asked}' INT; echo ready; until [ -e {done} ]; do echo .; sleep 0.1; done"
    )
    process = bench.start(f'sh("{script}", sigterm_timeout="600")')
    assert process.stdout is not None
    assert any(b"ready" in line for line in process.stdout)
    process.stdout.close()
    wait_until(asked.exists, "the run is being stopped")
    process.send_signal(signal.SIGHUP)
    wait_until(lambda: "still waiting for" in log.read_text(), "it goes on with the stop")
    assert "not waiting any longer" not in log.read_text()
    done.touch()
    assert process.wait(60) == 0


def test_on_exit_shutdown_takes_the_system_down_with_the_required_process(bench: Bench):
    done = bench.run('sh("exit 4", on_exit=Shutdown()), sh("exec sleep 1000")')
    assert done.returncode == 1
    assert b"process has died [pid" in done.stdout
    assert bench.survivors() == []


def test_sigquit_is_an_orderly_stop_too(bench: Bench):
    terminal = bench.terminal('sh("echo ready; exec sleep 1000")')
    terminal.wait_for("ready")
    terminal.signal(signal.SIGQUIT)
    assert terminal.exit_code() == 0
    assert bench.survivors() == []


def watchdog_of(terminal: Terminal) -> psutil.Process:
    wait_until(lambda: children_with(terminal.pid, "watchdog.py"), "the watchdog")
    (watchdog,) = children_with(terminal.pid, "watchdog.py")
    return watchdog


def test_a_killed_watchdog_is_replaced(bench: Bench):
    terminal = bench.terminal('sh("echo ready; exec sleep 1000")')
    terminal.wait_for("ready")
    watchdog_of(terminal).kill()
    terminal.wait_for("the watchdog was killed; restarting it")
    terminal.kill()
    wait_until(lambda: bench.survivors() == [], "nothing is left")


def test_a_suspended_watchdog_does_not_delay_the_end(bench: Bench):
    terminal = bench.terminal('sh("echo ready; exec sleep 1000")')
    terminal.wait_for("ready")
    watchdog = watchdog_of(terminal)
    watchdog.suspend()
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert not watchdog.is_running()


def test_a_reader_that_goes_away_does_not_hide_an_earlier_failure(bench: Bench):
    talk = "while :; do echo talk; sleep 0.05; done"
    command = bench.start(f'sh("exit 3", name="dead"), sh("{talk}", name="talk")')
    assert command.stdout is not None
    for line in command.stdout:
        if b"process has died" in line:
            break
    command.stdout.close()
    assert command.wait(60) == 1
    assert bench.survivors() == []


LATE = 'TimerAction(period={period}, cancel_on_shutdown={cancel}, actions=[LogInfo(msg="{text}")])'


def test_a_shutdown_waits_for_a_timer_that_it_does_not_cancel(bench: Bench):
    """As in ROS 2; also for a timer that begins with the shutdown."""
    kept = LATE.format(period=1.0, cancel=False, text="kept")
    begun = LATE.format(period=0.1, cancel=True, text="begun")
    cancelled = LATE.format(period=0.9, cancel=True, text="cancelled")
    handler = f"RegisterEventHandler(OnShutdown(on_shutdown=[{begun}]))"
    # The shutdown begins at once: no slow process delays it until the other timers are due.
    stop = "TimerAction(period=0.0, actions=[Shutdown()])"
    done = bench.run(f'sh("exec sleep 1000"), {stop}, {kept}, {cancelled}, {handler}')
    output = done.stdout.decode()
    assert done.returncode == 0
    assert "cancel_on_shutdown=False" in output
    # In either order: "kept" comes first if the run was held up for longer than its period.
    assert sorted(re.findall(r"launch.user\]: (.*)", output)) == ["begun", "kept"]


def test_a_second_ctrl_c_cancels_a_timer_that_holds_up_the_shutdown(bench: Bench):
    terminal = bench.terminal(
        'sh("echo ready; exec sleep 600"), ' + LATE.format(period=600.0, cancel=False, text="kept")
    )
    terminal.wait_for("ready")
    terminal.ctrl_c()
    terminal.wait_for("waiting for a timer")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert "kept" not in terminal.text


def crashing(signum: str, name: str) -> str:
    """A process that ends by this signal, from itself, in answer to SIGINT."""
    return f"sh(\"trap 'kill -{signum} $$' INT; echo ready; {LOOP}\", name='{name}')"


LOOP = "while :; do sleep 0.05; done"
DIED = r"\[ERROR\] \[{0}\]: process has died \[pid \d+, exit code -{1}, cmd '.*'\]\. \({2}"


def test_a_crash_in_answer_to_the_stop_is_a_death(control_bench: ControlBench):
    actions = f"{crashing('SEGV', 'a')}, {crashing('KILL', 'b')}, {crashing('TERM', 'c')}"
    with control_bench.launch(actions) as run:
        for name in ("a-1", "b-2", "c-3"):
            run.wait_for(f"[{name}] ready")
        run.ask("quit")
        assert run.exit_code() == 1
    for name, signum in (("a-1", signal.SIGSEGV), ("b-2", signal.SIGKILL)):
        assert re.search(DIED.format(name, int(signum), signum.name), run.screen)
        assert re.search(rf"{name} +{signum.name}(, core dumped)? when it was stopped ", run.screen)
    assert "[INFO] [c-3]: process was stopped" in run.screen
    last = run.screen.splitlines()[-1]
    assert re.match(r"\[ERROR\] \[launch\]: exit code 1: (a-1 and b-2|b-2 and a-1) ended", last)


@pytest.mark.parametrize(("signum", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_crash_when_the_launcher_is_signalled_has_the_exit_code_of_failed_runs(
    control_bench: ControlBench, signum: int, code: int
):
    with control_bench.launch(crashing("SEGV", "a")) as run:
        run.wait_for("[a-1] ready")
        run.process.send_signal(signum)
        assert run.exit_code() == code
    assert f"exit code {code}: a-1 ended unexpectedly (SIGSEGV" in run.screen


@pytest.mark.parametrize("verb", ["stop", "restart"])
def test_a_crash_when_a_user_stops_a_process_is_a_death_and_the_run_goes_on(
    control_bench: ControlBench, verb: str
):
    more = ("--restart", "a=always,delay=0", "--required", "a", "--exit-when-any-dies")
    actions = f"{crashing('ABRT', 'a')}, sh('echo ready; exec sleep 1000', name='b')"
    with control_bench.launch(actions, *more) as run:
        run.wait_for("[a-1] ready")
        run.wait_for("[b-2] ready")
        run.ask(verb, "a")
        row = run.row("a-1")
        assert row["state"] == ("STOPPED" if verb == "stop" else "RUNNING")
        assert (row["last_exit"]["returncode"], row["last_exit"]["asked"]) == (-6, False)
        run.ask("quit")
        assert run.exit_code() == 1
    assert re.search(DIED.format("a-1", 6, "SIGABRT"), run.screen)
    assert re.search(r"exit code 1: a-1 ended unexpectedly \(SIGABRT(, core dumped)?\)", run.screen)


def last_line_of_a_stop(bench: ControlBench, *scripts: str) -> str:
    """The end of a good run whose processes do this when they are stopped."""
    actions = ", ".join(f"sh(\"trap '{script}' INT; echo ready; {LOOP}\")" for script in scripts)
    with bench.launch(actions) as run:
        wait_until(lambda: run.screen.count("] ready\n") == len(scripts), "all are ready")
        run.ask("quit")
        assert run.exit_code() == 0
        return run.screen.splitlines()[-1]


def test_an_unusual_exit_code_after_the_stop_is_named_in_the_last_line(control_bench: ControlBench):
    codes = (f"exit {code}" for code in (0, 1, 7, 130, 139, 143))
    last = last_line_of_a_stop(control_bench, *codes)
    assert "exit code 0: 4 processes ended as expected after" in last
    assert "; stopped with unusual exit codes: sh-3 (7), sh-5 (139, SIGSEGV);" in last


def test_a_process_that_its_own_timer_ends_in_a_stop_has_not_died(control_bench: ControlBench):
    """As a node does that limits the time of its clean-up."""
    last = last_line_of_a_stop(control_bench, "kill -PROF $$")
    assert "exit code 0: stopped with an unusual exit code: sh-1 (SIGPROF);" in last
