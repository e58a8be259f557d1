"""A process with its real state machine and queue of requests, on a simulated clock."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Sequence

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartPolicy, StopPolicy
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import (
    POLITE,
    Action,
    Exited,
    MachineAction,
    MachineCommand,
    MachineEvent,
    ProcessState,
    ReportExit,
    Signal,
)
from launcher.run.requests.request_queue import (
    Act,
    Answer,
    Do,
    ProcessPhase,
    ProcessRequest,
    Purpose,
    QueueAction,
    RequestOrder,
    RequestQueue,
    Situation,
    StepPhase,
)
from launcher.run.requests.request_result import Kind


class Clock:
    """Calls what is due, in order of time."""

    def __init__(self) -> None:
        self.now = 0.0
        self._due: list[tuple[float, int, Callable[[], object]]] = []
        self._count = itertools.count()

    def call_later(self, delay_s: float, do: Callable[[], object]) -> None:
        heapq.heappush(self._due, (self.now + delay_s, next(self._count), do))

    def run(self, until_s: float = float("inf")) -> None:
        while self._due and self._due[0][0] <= until_s:
            self.now, _, do = heapq.heappop(self._due)
            do()
        self.now = max(self.now, until_s) if until_s != float("inf") else self.now


class Client:
    """One request, and what became of it."""

    def __init__(self, purpose: Purpose, *, is_urgent: bool) -> None:
        self.request = ProcessRequest(purpose, lambda result: None, is_urgent=is_urgent)
        self.kinds: list[Kind] = []
        self.pid: int | None = None
        self.answered_s = 0.0
        self.has_left = False
        self.is_dropped = False  # given up before it had begun
        self.is_living = True  # not answered, and not given up before it had begun


class BenchProcess:
    """Takes `stop_s()` to stop and `start_s()` until its program runs; `is_paced`: its start waits.

    `orders` are the orders of the queue so far; `unasked` counts starts that nobody waited for.
    """

    def __init__(
        self,
        clock: Clock,
        *,
        restart: RestartPolicy | None = None,
        stop_s: Callable[[], float] = lambda: 1.0,
        start_s: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self.clock = clock
        self.machine = ProcessMachine(restart or RestartPolicy(), StopPolicy(), chance=lambda: 0.5)
        self.queue = RequestQueue()
        self.stop_s = stop_s
        self.start_s = start_s
        self.is_paced = self.waits = False
        self.is_deaf = False  # even to SIGKILL
        self.refusal: Kind | None = None
        self.pid: int | None = None
        self.last_end: ReportExit | None = None
        self.ended_s = 0.0
        self.orders: list[RequestOrder] = []
        self.unasked = 0
        self._pids = itertools.count(1)
        self._clients: dict[ProcessRequest, Client] = {}

    # ---- what happens to it

    def feed(self, event: MachineEvent) -> None:
        for action in self.machine.handle(event, self.clock.now):
            self._act(action)
        if self.machine.state is ProcessState.STOPPING and self.pid is None:
            self.machine.handle(MachineCommand.START_CANCELLED, self.clock.now)
        deadline = self.machine.deadline
        if deadline is not None:
            self.clock.call_later(deadline - self.clock.now, lambda: self.feed(MachineCommand.TICK))
        self.clock.call_later(0, self.settle)

    def _act(self, action: Action) -> None:
        match action:
            case MachineAction.SPAWN if not self.is_paced:
                self.spawn()
            case Signal(signum=signum) if not self.is_deaf:
                is_polite = signum in POLITE
                self.end(-int(signum), self.stop_s() if is_polite else 0.0)
            case ReportExit():
                self.last_end, self.pid = action, None
                self.ended_s = self.clock.now

    def spawn(self) -> None:
        """The turn of its start has come."""
        pid = self.pid = next(self._pids)
        if delay_s := self.start_s():
            self.clock.call_later(delay_s, lambda: self._runs(pid))
        else:
            self.feed(MachineCommand.STARTED)

    def _runs(self, pid: int) -> None:
        if self.pid == pid:
            self.feed(MachineCommand.STARTED)

    def end(self, code: int, after_s: float = 0.0) -> None:
        """Its present life ends."""
        pid = self.pid

        def exited() -> None:
            if pid is not None and self.pid == pid:
                self.feed(Exited(Outcome(returncode=code)))

        self.clock.call_later(after_s, exited)

    # ---- requests

    def ask(self, purpose: Purpose, *, is_urgent: bool = False) -> Client:
        client = Client(purpose, is_urgent=is_urgent)
        self._clients[client.request] = client
        self.settle()
        self._carry_out(self.queue.add(client.request, self.situation))
        self.settle()
        return client

    def leave(self, client: Client) -> None:
        client.has_left = True
        step = self.queue.current
        has_begun = step is not None and step.phase is not StepPhase.PENDING
        client.is_living = step is not None and has_begun and client.request in step.requests
        client.is_dropped = not client.is_living
        self.queue.withdraw(client.request)
        self.settle()

    def settle(self) -> None:
        while actions := self.queue.settle(self.situation):
            self._carry_out(actions)

    @property
    def situation(self) -> Situation:
        return Situation(
            now=self.clock.now, phase=self.phase, last_end=self.last_end, refusal=self.refusal
        )

    @property
    def phase(self) -> ProcessPhase:
        if self.machine.is_stuck:
            return ProcessPhase.STUCK
        match self.machine.state:
            case ProcessState.STARTING if self.pid is None:
                return ProcessPhase.WAITING if self.waits else ProcessPhase.QUEUED
            case ProcessState.STARTING:
                return ProcessPhase.STARTING
            case ProcessState.RUNNING:
                return ProcessPhase.RUNNING
            case ProcessState.STOPPING:
                return ProcessPhase.STOPPING
            case ProcessState.BACKOFF:
                return ProcessPhase.BACKOFF
        return ProcessPhase.ENDED

    def _carry_out(self, actions: Sequence[QueueAction]) -> None:
        for action in actions:
            match action:
                case Do(order=order):
                    self.orders.append(order)
                    self._do(order)
                case Answer(requests=requests, kind=kind):
                    for request in requests:
                        client = self._clients[request]
                        client.kinds.append(kind)
                        client.pid, client.answered_s = self.pid, self.clock.now
                        client.is_living = False
                case Act(step=step):
                    (request,) = step.requests
                    self._clients[request].kinds.append(Kind.SIGNALLED)
                    self.queue.finish(step)

    def _do(self, order: RequestOrder) -> None:
        match order:
            case RequestOrder.STOP:
                self.feed(MachineCommand.USER_STOP)
            case RequestOrder.START:
                living = [one for one in self._clients.values() if one.is_living]
                starters = [one for one in living if one.request.purpose.starts]
                self.unasked += not starters
                for one in starters:
                    one.is_living = not one.has_left  # this start was the rest of it
                self.feed(MachineCommand.USER_START)
            case RequestOrder.SKIP_WAIT:
                self.waits = False
                self.spawn()
