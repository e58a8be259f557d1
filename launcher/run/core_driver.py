"""Feeds the interpreter with events, and carries out the effects that it returns."""

from __future__ import annotations

import errno
import functools
import os
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence

from launcher.base.model import events
from launcher.run.processes.machine_events import MachineCommand
from launcher.run.processes.process import Process, adapted

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Protocol

    from launcher.base.model.reload_changes import Known, Reload
    from launcher.base.model.run_options import RunOptions
    from launcher.base.model.spec import ProcessSpec
    from launcher.run.launch_timers import LaunchTimers
    from launcher.run.processes.machine_events import ReportExit
    from launcher.run.ros_requests import RosRequests
    from launcher.run.run import Run

    class Core(Protocol):
        """The interpreter of a run (`launcher.language.interpreter`), or one of a test."""

        # Effects of the launch file's static part, and of an event.
        def start(self) -> Sequence[events.Effect]: ...
        def handle(self, event: events.Event) -> Sequence[events.Effect]: ...

        # Whether ProcessOutput is wanted for this process.
        def watches_output(self, process_id: int) -> bool: ...

        # Whether the launch file has failed, which makes the exit code 1.
        @property
        def has_failed(self) -> bool: ...

        # What was started so far, ready for JSON, and as lines for users.
        def plan(self) -> Mapping[str, Any]: ...
        def plan_lines(self) -> Sequence[str]: ...

        # What it would still do by itself: `OnProcessExit`, `2 timers`.
        def intentions(self) -> Sequence[str]: ...

    class Evaluation(Protocol):
        """A launch file that was evaluated again, which changes nothing until it is adopted."""

        @property
        def reload(self) -> Reload: ...
        def discard(self) -> None: ...

    class ReloadableCore(Core, Protocol):
        """The interpreter of a launch file that can be evaluated again during the run."""

        # The options of the run, with its supervision files as they are now; LauncherError.
        def read_options(self) -> RunOptions: ...

        # LauncherError. `adapt` applies these options. The first timers count for so many seconds.
        def evaluate_again(
            self,
            known: Sequence[Known],
            options: RunOptions,
            adapt: Callable[[ProcessSpec], ProcessSpec],
            elapsed_s: float,
        ) -> Evaluation: ...
        def adopt(self, evaluation: Any) -> None: ...

        # Do not end for want of processes while this is true.
        def stay_while(self, condition: Callable[[], bool]) -> None: ...

        # Whether the launch file has asked something of its node: transitions, components.
        def is_steered(self, spec: ProcessSpec) -> bool: ...

        # What the evaluation has read.
        def launch_files(self) -> list[str]: ...


_NO_TIMER = -1


class CoreDriver:
    """One for a run."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._core = run.core
        self._reactor = run.reactor
        self._log = run.log
        self._processes = run.all_processes
        self._requests: RosRequests | None = None
        self._watching: dict[int, bool] = {}
        self._loads: dict[int, events.LoadComponent] = {}
        self._inbox: deque[events.Event] = deque()
        self._busy = False
        self._settling = False
        self.stays: Callable[[], bool] = lambda: False

    @property
    def expects_more(self) -> bool:
        """Whether a timer, an unhandled event or `stays` may start something."""
        return bool(self._timers or self._inbox or self._busy) or self.stays()

    @property
    def is_loading(self) -> bool:
        return self._requests is not None and self._requests.is_loading

    def start(self) -> None:
        """Carry out the static part as a whole before the first event is handled."""
        self._busy = True
        self._carry_out(self._core.start())
        self._busy = False
        self._pump()

    def feed(self, event: events.Event) -> None:
        """Pass an event to the core after the effects of earlier events."""
        self._inbox.append(event)
        self._pump()

    def carry_out(self, effects: Sequence[events.Effect]) -> None:
        """Effects of another evaluation: its timers wait for the preparation as the earlier did."""
        self._busy = True
        waiting = filter(self._run.driver.awaits_preparation, self._processes.values())
        self._carry_out(effects, waiting)
        self._busy = False
        self._pump()

    def nudge(self) -> None:
        """Nothing may be left to do: let the core find out."""
        self.feed(events.TimerFired(_NO_TIMER))
        self._run.idle()

    def stay_while(self, condition: Callable[[], bool]) -> None:
        """Do not end for want of processes while this is true."""
        self.stays = condition
        if hasattr(self._core, "stay_while"):
            self._core.stay_while(condition)

    def forget(self) -> None:
        """Another launch file has the run: drop the timers and events of the earlier one."""
        self._timers.cancel_all(outliving=True)
        self._inbox.clear()
        self._watching.clear()

    def started(self, process: Process, pid: int) -> None:
        """A process runs."""
        self.feed(events.ProcessStarted(process_id=process.process_id, pid=pid))
        self._timers.settled(process)

    def ended(self, process: Process, pid: int, end: ReportExit) -> None:
        """A process has exited, or could not be started."""
        self._report_end(process, pid, end)
        self._timers.settled(process)

    def cancelled(self, process: Process) -> None:
        """A process was stopped before its start was complete."""
        if not process.machine.is_held:
            self.not_started(process.process_id, errno.ECANCELED)
        self._timers.settled(process)

    def _report_end(self, process: Process, pid: int, end: ReportExit) -> None:
        if process.is_replaced and end.outcome.returncode is not None:
            return
        process.is_replaced = False
        will_restart = end.retry_in_s is not None or process.machine.is_held
        returncode = end.outcome.returncode
        if returncode is None:
            number = end.outcome.spawn_errno or errno.EIO
            self.not_started(process.process_id, number, will_restart=will_restart)
            return
        number = process.process_id
        self.feed(events.ProcessExited(number, pid, returncode, will_restart=will_restart))

    def not_started(self, process_id: int, number: int, *, will_restart: bool = False) -> None:
        self.feed(
            events.SpawnFailed(
                process_id=process_id,
                errno=number,
                reason=os.strerror(number),
                will_restart=will_restart,
            )
        )

    def _pump(self) -> None:
        if self._busy:
            return  # a caller further up the stack continues with the inbox
        self._busy = True
        while self._inbox:
            effects = self._core.handle(self._inbox.popleft())
            self._watching.clear()  # a handler may have been added or removed
            self._carry_out(effects)
        self._busy = False

    def _carry_out(self, effects: Sequence[events.Effect], waiting: Iterable[Process] = ()) -> None:
        """Their timers count from the first of their starts, or of those that are `waiting`."""
        starting, timers = [*waiting], {}
        for effect in effects:
            match effect:
                case events.StartProcess():
                    if process := self._start(effect):
                        starting.append(process)
                case events.CallLater(timer_id=timer_id):
                    timers[timer_id] = effect
                case events.CancelTimer(timer_id=timer_id):
                    if timers.pop(timer_id, None) is None:
                        self._timers.cancel(timer_id)
                case events.LogMessage(level=level, logger=logger, text=text):
                    self._log.log(level, logger, text, sink=effect.sink, line=effect.line)
                case events.LoadComponent() | events.ChangeState() | events.WatchLifecycle():
                    if isinstance(effect, events.LoadComponent):
                        self._loads[effect.request_id] = effect
                    self._ros.send(effect)
                case events.UseSimTime(value=value):
                    self._use_sim_time(value)
                case events.RequestShutdown(reason=reason, is_interrupted=is_interrupted):
                    self._run.shutdown.decided(reason, is_interrupted=is_interrupted)
                case _ if effect.process_id in self._processes:  # else: stopped before its start
                    self._control(self._processes[effect.process_id], effect)
        self._timers.add(timers.values(), starting)

    def _start(self, effect: events.StartProcess) -> Process | None:
        """Start a new process, unless a part refuses it, as that for a host that is skipped."""
        run = self._run
        number = len(self._processes)
        spec = adapted(effect.spec, run.options)
        if any(part.refuses(spec) for part in run.parts):
            self.not_started(effect.process_id, errno.ECANCELED)
            return None
        prefix = run.screen.prefix(spec, number)
        process = Process(effect.process_id, spec, number=number, prefix=prefix)
        self._processes[effect.process_id] = process
        for part in run.parts:
            part.adding(process)
        run.driver.advance(process, MachineCommand.START)
        for part in run.parts:
            part.added(process)
        return process

    def _control(self, process: Process, effect: events.Effect) -> None:
        match effect:
            case events.SignalProcess(signum=signum):
                self._run.driver.signal(process, signum)
            case events.StopProcess():
                self._run.driver.advance(process, MachineCommand.STOP)
            case events.WriteStdin(data=data):
                self._run.driver.write_stdin(process, data)

    # ---- timers

    @functools.cached_property
    def _timers(self) -> LaunchTimers:
        """Imported after the first processes have been started."""
        from launcher.run.launch_timers import LaunchTimers

        return LaunchTimers(self._reactor, self._run.driver, self._fire, lambda: self._simulation)

    @property
    def elapsed_s(self) -> float:
        """Seconds since the start of the run, as the timers of the launch file count."""
        return self._timers.elapsed_s

    def _fire(self, timer_id: int) -> None:
        self.feed(events.TimerFired(timer_id=timer_id))
        self._run.idle()

    def cancel_timers(self, *, all_of_them: bool = False) -> int:
        """Cancel the timers that do not outlive a shutdown, or all; returns how many are left."""
        self._timers.cancel_all(outliving=all_of_them)
        return len(self._timers)

    # ---- ROS

    @property
    def _ros(self) -> RosRequests:
        """Imported with the first request: most launch files have none."""
        if self._requests is None:
            from launcher.run.ros_requests import RosRequests

            self._requests = RosRequests(
                self._reactor,
                self._log,
                self._run.agent_env,
                self._processes.values(),
                self._ros_answered,
            )
        return self._requests

    @property
    def _simulation(self) -> RosRequests | None:
        """What has the ROS clock of the run, if that is a simulation's."""
        requests = self._requests
        return requests if requests is not None and requests.sim_time else None

    def _use_sim_time(self, value: bool) -> None:
        self._ros.use_sim_time(value)
        if value:
            self._timers.move_to(self._ros)

    def _ros_answered(self, event: events.Event) -> None:
        if isinstance(event, (events.TimerFired, events.TimerLost)):
            self._timers.forget(event.timer_id)
        if isinstance(event, events.ComponentLoaded):
            load = self._loads.pop(event.request_id)
            if event.error is None:
                for part in self._run.parts:
                    part.loaded(load, event.full_node_name)
        self.feed(event)
        if not self._settling:
            self._run.idle()

    def settle_requests(self) -> None:
        """Answer the requests that nobody can answer any more."""
        if self._requests is not None and not self._settling:
            self._settling = True
            self._requests.settle(expects_more=self.expects_more)
            self._settling = False

    def close_requests(self) -> None:
        if self._requests is not None:
            self._requests.close()

    # ---- output

    def watches(self, process: Process) -> bool:
        """Whether the core reads the output of this process; called for each read."""
        number = process.process_id
        if number not in self._watching:
            self._watching[number] = self._core.watches_output(number)
        return self._watching[number]

    def output(self, process: Process, stream: str, data: bytes) -> None:
        stream = "stdout" if stream == "both" else stream
        self.feed(events.ProcessOutput(process_id=process.process_id, stream=stream, data=data))
