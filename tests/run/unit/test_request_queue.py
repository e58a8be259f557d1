"""Which request does what in which state; the same table is in docs/reference/control.md."""

from __future__ import annotations

import itertools
import random
import re
from collections.abc import Callable

import pytest

from launcher.base.model.spec import RestartMode, RestartPolicy
from launcher.run.processes.machine_events import MachineCommand, ProcessState
from launcher.run.requests.request_queue import ProcessPhase, Purpose, RequestOrder
from launcher.run.requests.request_result import Kind
from tests.run.unit.request_bench import BenchProcess, Client, Clock
from tests.support.repository import docs_page

CONTROL = docs_page("control")
ACT, STOP, START, RESTART, DEBUG = Purpose
ALWAYS = RestartPolicy(mode=RestartMode.ALWAYS, delay_s=1000.0)


def new(**options: object) -> BenchProcess:
    return BenchProcess(Clock(), **options)  # type: ignore[arg-type]


def stopped() -> BenchProcess:
    return new()


def held() -> BenchProcess:
    one = running()
    one.ask(STOP)
    one.clock.run(until_s=5.0)
    return one


def waiting() -> BenchProcess:
    one = new()
    one.is_paced = one.waits = True
    one.feed(MachineCommand.START)
    return one


def queued() -> BenchProcess:
    one = new()
    one.is_paced = True
    one.feed(MachineCommand.START)
    return one


def starting() -> BenchProcess:
    one = new(start_s=lambda: 1.0)
    one.feed(MachineCommand.START)
    return one


def running() -> BenchProcess:
    one = new()
    one.feed(MachineCommand.START)
    return one


def backing_off() -> BenchProcess:
    one = new(restart=ALWAYS)
    one.feed(MachineCommand.START)
    one.end(1)
    one.clock.run(until_s=1.0)
    return one


def stopping_otherwise() -> BenchProcess:
    one = running()
    one.feed(MachineCommand.STOP)
    return one


def stopping_by(asked: Purpose) -> Callable[[], BenchProcess]:
    def make() -> BenchProcess:
        one = running()
        one.ask(asked)
        return one

    return make


def stuck() -> BenchProcess:
    one = running()
    one.is_deaf = True
    one.ask(STOP)
    one.clock.run(until_s=100.0)
    return one


def started_and_queued() -> BenchProcess:
    one = stopped()
    one.is_paced = True
    one.ask(START)
    return one


STATES = {
    "stopped, exited, given up": stopped,
    "held: stopped by a user": held,
    "waiting for other processes": waiting,
    "waiting for its turn": queued,
    "waiting for its turn, by a request": started_and_queued,
    "starting": starting,
    "running": running,
    "backing off": backing_off,
    "stopping by the launch file or a budget": stopping_otherwise,
    "stopping by `stop`": stopping_by(STOP),
    "stopping by `restart`": stopping_by(RESTART),
    "stopping by `debug`": stopping_by(DEBUG),
    "stuck: it survives SIGKILL": stuck,
}

# State -> request -> what the queue does at once, the answer in the end, the cell in the document.
# `is_paced` is over after the request, so that what was queued starts.
REFUSED = {
    STOP: ([], Kind.NOT_RUNNING, "refused"),
    START: ([RequestOrder.START], Kind.STARTED, "starts"),
    RESTART: ([RequestOrder.START], Kind.STARTED, "starts"),
}
TABLE = {
    "stopped, exited, given up": REFUSED,
    "held: stopped by a user": REFUSED,
    "waiting for other processes": {
        STOP: ([RequestOrder.STOP], Kind.START_CANCELLED, "gives the start up"),
        START: ([RequestOrder.SKIP_WAIT], Kind.STARTED, "starts at once"),
        RESTART: ([RequestOrder.SKIP_WAIT], Kind.STARTED, "starts at once"),
    },
    "waiting for its turn": {
        STOP: ([RequestOrder.STOP], Kind.START_CANCELLED, "gives the start up"),
        START: ([], Kind.QUEUED, "refused: is queued"),
        RESTART: ([RequestOrder.BEGIN_AGAIN], Kind.QUEUED, "is queued, with the files of now"),
    },
    "waiting for its turn, by a request": {
        STOP: ([RequestOrder.STOP], Kind.START_CANCELLED, "gives the start up"),
        START: ([], Kind.STARTED, "shares the answer"),
        RESTART: (
            [RequestOrder.BEGIN_AGAIN],
            Kind.STARTED,
            "shares the answer, with the files of now",
        ),
    },
    "starting": {
        STOP: ([RequestOrder.STOP], Kind.STOPPED, "stops"),
        START: ([], Kind.STARTED, "is answered when it runs"),
        RESTART: ([RequestOrder.STOP], Kind.STARTED, "stops, then starts"),
    },
    "running": {
        STOP: ([RequestOrder.STOP], Kind.STOPPED, "stops"),
        START: ([], Kind.ALREADY_RUNNING, "refused"),
        RESTART: ([RequestOrder.STOP], Kind.STARTED, "stops, then starts"),
    },
    "backing off": {
        STOP: ([RequestOrder.STOP], Kind.RESTART_CANCELLED, "cancels the restart"),
        START: ([RequestOrder.START], Kind.STARTED, "starts at once"),
        RESTART: ([RequestOrder.START], Kind.STARTED, "starts at once"),
    },
    "stopping by the launch file or a budget": {
        STOP: ([RequestOrder.STOP], Kind.STOPPED, "is answered at its end"),
        START: ([], Kind.STARTED, "starts after its end"),
        RESTART: ([RequestOrder.STOP], Kind.STARTED, "starts after its end"),
    },
    "stopping by `stop`": {
        STOP: ([], Kind.STOPPED, "shares the answer"),
        START: ([], Kind.STARTED, "starts after its end"),
        RESTART: ([], Kind.STARTED, "starts after its end"),
    },
    "stopping by `restart`": {
        STOP: ([], Kind.STOPPED, "overtakes: it stays stopped"),
        START: ([], Kind.STARTED, "shares the answer"),
        RESTART: ([], Kind.STARTED, "shares the answer"),
    },
    "stopping by `debug`": {
        STOP: ([], Kind.STOPPED, "overtakes: it stays stopped"),
        START: ([], Kind.STARTED, "shares the answer"),
        RESTART: ([], Kind.STARTED, "restarts after it"),
    },
    "stuck: it survives SIGKILL": {
        STOP: ([], Kind.STUCK, "refused"),
        START: ([], Kind.STUCK, "refused"),
        RESTART: ([], Kind.STUCK, "refused"),
    },
}
CELLS = [(state, asked) for state, row in TABLE.items() for asked in row]


@pytest.mark.parametrize(("state", "asked"), CELLS)
def test_a_request_does_what_the_table_says(state: str, asked: Purpose):
    process = STATES[state]()
    process.orders.clear()
    orders, kind, _ = TABLE[state][asked]
    client = process.ask(asked)
    assert process.orders == orders
    if process.is_paced and client.kinds != [kind]:
        process.is_paced = False
        process.spawn()
    process.clock.run(until_s=process.clock.now + 20.0)
    assert client.kinds == [kind]
    if kind in (Kind.STARTED, Kind.STOPPED):
        assert process.phase is (
            ProcessPhase.ENDED if kind is Kind.STOPPED else ProcessPhase.RUNNING
        )


def test_the_document_has_the_table():
    text = CONTROL
    table = {
        cells[0]: cells[1:]
        for line in text.splitlines()
        if line.startswith("|") and (cells := re.split(r" *\| *", line.strip("| ")))
    }
    for state, row in TABLE.items():
        assert table[state] == [cell for _, _, cell in row.values()], state


@pytest.mark.parametrize("later", [START, RESTART])
@pytest.mark.parametrize("first", [START, RESTART])
def test_equal_requests_that_are_pending_get_the_same_pid(first: Purpose, later: Purpose):
    process = stopping_otherwise()
    clients = [process.ask(first), *(process.ask(later) for _ in range(3))]
    process.clock.run()
    assert [one.kinds for one in clients] == [[Kind.STARTED]] * 4
    assert {one.pid for one in clients} == {2}
    assert process.orders.count(RequestOrder.START) == 1


def test_a_stop_answers_the_starts_that_it_overtakes_and_the_last_request_counts():
    process = running()
    restart, again = process.ask(RESTART), process.ask(RESTART)
    stop = process.ask(STOP)
    assert restart.kinds == again.kinds == [Kind.OVERTAKEN]
    start = process.ask(START)
    last = process.ask(STOP)
    assert start.kinds == [Kind.OVERTAKEN]
    process.clock.run()
    assert stop.kinds == last.kinds == [Kind.STOPPED]
    assert process.machine.state is ProcessState.STOPPED
    assert process.orders == [RequestOrder.STOP]


def test_nothing_begins_for_a_client_that_has_gone():
    process = running()
    stop, start, restart = (process.ask(asked) for asked in (STOP, START, RESTART))
    for client in (start, restart):
        process.leave(client)
    process.clock.run()
    assert (stop.kinds, start.kinds, restart.kinds) == ([Kind.STOPPED], [], [])
    assert process.machine.state is ProcessState.STOPPED


def test_one_of_two_clients_that_share_may_go():
    process = running()
    process.ask(STOP)
    start, restart = process.ask(START), process.ask(RESTART)
    process.leave(restart)
    process.clock.run()
    assert (start.kinds, restart.kinds) == ([Kind.STARTED], [])


def test_a_restart_that_has_begun_is_finished_without_its_client():
    process = running()
    restart = process.ask(RESTART)
    process.leave(restart)
    process.clock.run()
    assert process.machine.state is ProcessState.RUNNING
    assert process.pid == 2 and restart.kinds == []


def test_what_would_start_a_process_is_refused_when_the_run_stops():
    process = running()
    stop, start = process.ask(STOP), process.ask(START)
    process.refusal = Kind.RUN_STOPPING
    process.clock.run()
    assert (stop.kinds, start.kinds) == ([Kind.STOPPED], [Kind.RUN_STOPPING])


def test_other_requests_wait_for_earlier_ones():
    process = running()
    process.ask(RESTART)
    act = process.ask(ACT)
    assert act.kinds == []
    process.clock.run()
    assert act.kinds == [Kind.SIGNALLED]


def test_what_is_urgent_does_not_wait_for_an_end():
    process = running()
    stop, start = process.ask(STOP), process.ask(START)
    urgent = process.ask(ACT, is_urgent=True)
    assert (stop.kinds, start.kinds, urgent.kinds) == ([], [], [Kind.SIGNALLED])


# ---- a storm


class Storm:
    """Clients that ask at random, and give some requests up."""

    def __init__(self, seed: int, *, clients: int, requests: int) -> None:
        self.random = random.Random(seed)
        self.clock = Clock()
        self.left = requests
        self.is_calm = False
        self.asked: list[tuple[BenchProcess, Client]] = []
        policies = [RestartPolicy(), RestartPolicy(mode=RestartMode.ALWAYS, delay_s=0.2)]
        self.processes = [
            BenchProcess(self.clock, restart=policy, stop_s=self._stop_s, start_s=self._start_s)
            for policy in policies * 2
        ]
        for process in self.processes:
            process.feed(MachineCommand.START)
            self._disturb(process)
        for _ in range(clients):
            self._next()

    def _stop_s(self) -> float:
        return self.random.choice((0.0, 0.01, self.random.uniform(0.0, 1.5)))

    def _start_s(self) -> float:
        return self.random.choice((0.0, 0.0, 0.008, 0.3))

    def _disturb(self, process: BenchProcess) -> None:
        """It crashes or ends by itself now and then."""
        if not self.is_calm:
            if process.phase is ProcessPhase.RUNNING:
                process.end(self.random.choice((0, 1, -11)))
            self.clock.call_later(self.random.uniform(0.1, 3.0), lambda: self._disturb(process))

    def _next(self) -> None:
        """The next request of a client, as soon as its last one is answered or given up."""
        if self.left == 0:
            self.is_calm = True
            return
        self.left -= 1
        process = self.random.choice(self.processes)
        client = process.ask(self.random.choice((STOP, START, RESTART, DEBUG, ACT)))
        self.asked.append((process, client))
        patience_s = self.random.choice((0.05, 0.5, 1000.0, 1000.0, 1000.0, 1000.0))
        began_s = self.clock.now

        def look() -> None:
            is_tired = self.clock.now - began_s > patience_s
            if is_tired and not client.kinds:
                process.leave(client)
            if client.kinds or client.has_left:
                self.clock.call_later(self.random.choice((0.0, 0.05, 0.4)), self._next)
            else:
                self.clock.call_later(0.02, look)

        look()


@pytest.mark.parametrize("seed", range(12))
def test_in_a_storm_every_request_is_answered_and_the_last_one_counts(seed: int):
    storm = Storm(seed, clients=6, requests=900)
    storm.clock.run()
    assert len(storm.asked) == 900
    for _, client in storm.asked:
        assert len(client.kinds) == (0 if client.has_left else 1)
    for process in storm.processes:
        assert process.queue.current is None
        assert process.unasked == 0
        *_, last = (
            client
            for other, client in storm.asked
            if other is process and client.request.purpose is not ACT and not client.is_dropped
        )
        if last.request.purpose is STOP:
            assert process.phase is ProcessPhase.ENDED
        else:
            has_ended = process.last_end is not None and not process.last_end.asked
            assert process.phase is ProcessPhase.RUNNING or (
                has_ended and process.ended_s >= last.answered_s
            )


def test_the_last_of_many_requests_at_once_decides():
    for asked in itertools.product((STOP, START, RESTART), repeat=5):
        process = running()
        clients = [process.ask(one) for one in asked]
        process.clock.run()
        assert all(len(one.kinds) == 1 for one in clients), asked
        expected = ProcessPhase.ENDED if asked[-1] is STOP else ProcessPhase.RUNNING
        assert process.phase is expected, asked
