"""Scenario steps and chaos on a running system."""

from __future__ import annotations

import re

import pytest

from tests.smoke.process.bench import DONE, PATIENT, Bench

CLOCK = 'sh("clock_{0}", "while :; do echo tick {0}; sleep 0.1; done"),'
TWO = (CLOCK.format(1), CLOCK.format(2))
ECHO = 'sh("echo", "while read line; do echo heard $line; done"),'


def test_a_killed_process_is_started_again(bench: Bench):
    bench.write(*TWO)
    bench.expect(
        """
        scenario:
          - {after: ready, at: 1 s, do: kill clock_1, name: kill}
          - {after: kill, at: 1 s, do: start clock_1, name: again}
        expect:
          - {name: death, process: clock_1, exits: SIGKILL, after: kill, within: 60 s}
          - {name: return, log: tick 1, after: again, within: 60 s}
          - {name: other, process: clock_2, restarts: 0}
          - {name: alive, process: clock_1}
        """
    )
    done = bench.smoke()
    assert done.returncode == 0, done.stdout
    steps = bench.report()["steps"]
    assert steps["again"] >= steps["kill"] + 1.0


@pytest.mark.thorough
def test_a_paused_process_prints_nothing(bench: Bench):
    bench.write(*TWO)
    bench.expect(
        """
        scenario:
          - {after: ready, at: 1 s, do: pause clock_1, name: nap}
          # What clock_1 had said before is read by now.
          - {after: nap, at: 1 s, do: pause clock_2 for 0.5 s, name: doze}
          - {after: doze, at: 2 s, do: resume clock_1, name: wake}
        expect:
          - {name: quiet, log: tick 1, count: 0, after: doze, within: 1.5 s}
          - {name: other, log: tick 2, after: 'doze: over', within: 60 s}
          - {name: awake, log: tick 1, after: wake, within: 60 s}
        """
    )
    done = bench.smoke()
    assert done.returncode == 0, done.stdout


def test_a_step_injects_faults_for_a_while(bench: Bench):
    bench.write(*TWO)
    bench.expect(
        """
        scenario:
          - {after: ready, do: inject clock_1 pause for 0.5 s, name: nap}
          - {after: 'nap: over', do: inject clock_2 kill, name: death}
        expect:
          - {name: awake, log: tick 1, after: 'nap: over', within: 60 s}
          - {name: killed, process: clock_2, exits: SIGKILL, after: death, within: 60 s}
        """
    )
    done = bench.smoke()
    assert done.returncode == 0, done.stdout


def test_an_injection_that_is_impossible_is_found_before_the_start(bench: Bench):
    bench.write(*TWO)
    bench.expect(
        """
        scenario:
          - {after: ready, do: inject clock_3 slow 4}
        """
    )
    done = bench.smoke()
    assert done.returncode == 2, done.stdout
    assert "the launch file starts no process 'clock_3'" in done.stderr
    bench.expect(
        """
        scenario:
          - {after: ready, do: inject clock_1 slow}
          - {after: ready, do: inject machine pause}
        """
    )
    done = bench.smoke()
    assert "slow needs FACTOR" in done.stderr
    assert "pause is about a process" in done.stderr


@pytest.mark.thorough
def test_a_step_waits_for_a_line_and_can_talk_to_a_process(bench: Bench):
    bench.write(PATIENT, ECHO)
    bench.expect(
        """
        scenario:
          - {after_log: here I am, process: patient, do: send echo hello there, name: hello}
          - {after: hello, at: 0.5 s, do: stop patient}
        expect:
          - {log: heard hello there, after: hello, within: 60 s}
          - {process: patient, alive: false}
        """
    )
    done = bench.smoke()
    assert done.returncode == 0, done.stdout


def test_a_step_for_an_unknown_process_is_refused_at_once(bench: Bench):
    bench.write(PATIENT)
    bench.expect("{for: 60 s, scenario: [{at: 1 s, do: kill patent}]}")
    done = bench.smoke()
    assert done.returncode == 2
    assert "tested.expect.yaml:1: the launch file starts no process 'patent'" in done.stderr
    assert "did you mean 'patient'?" in done.stderr
    assert not bench.evidence.exists()


@pytest.mark.thorough
def test_a_step_that_fails_and_one_that_never_comes_fail_the_run(bench: Bench):
    bench.write(PATIENT, DONE)
    bench.expect(
        """
        for: 12 s
        scenario:
          - {at: 10 s, do: kill done, name: wrong}
          - {after_log: never, do: stop patient, name: waiting}
        """
    )
    done = bench.smoke()
    assert done.returncode == 3
    assert "no process 'done' is running" in bench.judged("step wrong")["seen"]
    assert bench.judged("step waiting")["seen"] == "no line with 'never' came"


@pytest.mark.thorough
def test_chaos_does_the_same_with_the_same_seed(bench: Bench):
    bench.write(*TWO, CLOCK.format(3))
    words = ("--for=10", "--chaos=restart one of clock_* every 2 s", "--seed=7")
    told = [bench.smoke(*words) for _ in range(2)]
    assert [done.returncode for done in told] == [0, 0], told[0].stdout
    # How many fit into the time depends on when the system was ready.
    strokes = [re.findall(r"chaos (\d+): restart ([\w-]+)", done.stdout) for done in told]
    common = min(map(len, strokes))
    assert common >= 3
    assert strokes[0][:common] == strokes[1][:common]


@pytest.mark.thorough
def test_restart_policies_act_on_what_chaos_kills(bench: Bench):
    bench.write(*TWO, DONE)
    bench.expect("{expect: [{process: 'clock_*', restarts: '>= 1'}]}")
    done = bench.smoke(
        "--for=15",
        "--chaos=kill one of clock_* every 500 ms",
        "--restart=clock_*=always",
        "--expect-log=clock_1: tick",
    )
    assert done.returncode == 0, done.stdout
    assert "chaos 2: kill clock_" in done.stdout
