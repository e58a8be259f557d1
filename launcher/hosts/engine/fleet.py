"""The other hosts of a run: connects to them, and waits for them at its end."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.model.record import Record
from launcher.base.model.run_events import LinkChanged
from launcher.base.model.spec import ProcessSpec
from launcher.hosts.engine import host_links
from launcher.hosts.engine.link import Attached, LinkContext, LinkState
from launcher.hosts.engine.remote_host import RemoteHost, host_of
from launcher.hosts.engine.timers import Timers
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.file.order import Order, order_for
from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_events import Sample
    from launcher.hosts.engine.driver import HostsDriver
    from launcher.run.processes.process import Process
    from launcher.run.run import Run

CONNECT_S = 60.0  # for a link to report its outcome
LEAVE_S = 3.0  # after the last process, for a host that cannot be reached
_AWAITED = (LinkState.CONNECTING, LinkState.UNREACHABLE)


class FleetPlan(Record):
    """Which hosts a run needs from its start, and where its processes run (None: here).

    `environments` are variables for processes by the name of the host, besides those that the
    hosts file has. `title` says what is launched. `attached`: the processes run already, by these
    `orders`, by name.
    """

    host_of: Callable[[ProcessSpec], Host | None]
    needed: tuple[Host, ...] = ()
    environments: Mapping[str, Mapping[str, str]] = {}
    title: str = ""
    attached: Attached | None = None
    orders: Mapping[str, Order] = {}


class Fleet(Part):
    """One for a run with a hosts file; it supplies the driver of all processes."""

    no_reload = "a run with processes on other hosts cannot be reloaded"

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        assert isinstance(run.launched.hosts, FleetPlan)
        self._plan = run.launched.hosts
        self._reactor = run.reactor
        self._log = run.log
        coloured = "1" if run.screen.colour else "0"
        self._defaults = {"PYTHONUNBUFFERED": "1", "RCUTILS_COLORIZED_OUTPUT": coloured}
        self._hosts: dict[str, RemoteHost] = {}
        self._driver: HostsDriver
        self._connecting: set[str] = set()
        self._refused: list[str] = []
        self._connected: Callable[[], None] = lambda: None
        self._finishing: set[str] = set()
        self._done: Callable[[], None] | None = None
        self.has_connected = False
        self._is_stopping = False
        self._has_skipped = False
        self._timers = Timers(self._reactor)

    def driver(self) -> HostsDriver:
        """The driver of all processes, with the links of the hosts that are needed."""
        from launcher.hosts.engine.driver import HostsDriver

        self._driver = HostsDriver(self.run, self)
        if self._plan.attached is not None:
            names = [host.name for host in self._plan.needed]
            self._driver.begin_with(self._plan.attached.lines, names)
        for host in self._plan.needed:
            self._add(host)
        return self._driver

    @property
    def hosts(self) -> list[RemoteHost]:
        return list(self._hosts.values())

    def named(self, name: str) -> RemoteHost:
        return self._hosts[name]

    def _add(self, host: Host) -> RemoteHost:
        one = self._hosts[host.name] = RemoteHost(host)
        context = LinkContext(
            host=host,
            listener=self._driver,
            reactor=self._reactor,
            run_id=self.run.id,
            environment=self.run.env,
            title=self._plan.title,
            attached=self._plan.attached,
        )
        one.link = host_links.make_link(context)
        return one

    # ---- the start

    def holds_run(self) -> bool:
        """While hosts are connected to, nothing has begun that could be over."""
        return bool(self._connecting)

    def open(self, begin: Callable[[], None]) -> bool:
        """Connect to all hosts at the same time; the run begins when all have answered.

        If one refuses or cannot be reached, the run ends before anything was started.
        """
        self._connecting, self._connected = set(self._hosts), begin
        if not self._connecting:
            self._begin()
            return True
        for host in self.hosts:
            host.link.open()
        self._timers.after("", CONNECT_S, self._too_late)
        return True

    def _too_late(self) -> None:
        for name in sorted(self._connecting):
            self._answered(self._hosts[name], f"no answer within {CONNECT_S:g} s")

    def _answered(self, host: RemoteHost, refusal: str) -> None:
        self._connecting.discard(host.name)
        if refusal:
            self._refused.append(host.name)
            host.is_abandoned = True
            self._log.log("ERROR", "launch", f"{host.place} cannot be used: {refusal}")
        if self._connecting:
            return
        self._timers.cancel("")
        if self._refused:
            names = ", ".join(name for name in self._hosts if name in self._refused)
            if self._plan.attached is None:
                options = " ".join(f"--skip-host {name}" for name in self._refused)
                self._log.log("INFO", "launch", f"to start the others without: {options}")
            self.run.shutdown.host_failed(f"cannot be used: {names}")
        else:
            self._begin()

    def _begin(self) -> None:
        self.has_connected = True
        self._connected()

    @property
    def is_attaching(self) -> bool:
        """Whether there is a run on the hosts that was not attached to yet: leave it alone."""
        return self._plan.attached is not None and not self.has_connected

    # ---- processes

    def adding(self, process: Process) -> None:
        """Send the order for a new process to its host, unless that is this machine."""
        self._driver.place(process, merge=self.run.spawner.merges(process))

    def refuses(self, spec: ProcessSpec) -> bool:
        """Whether the process cannot be started: its host is skipped, or it has no place."""
        try:
            host = self._plan.host_of(spec)
        except LauncherError as error:
            self._log.log("ERROR", spec.name, f"not started: {error.message}")
            self.run.shutdown.host_failed(f"{spec.name} could not be placed")
            return True
        if host is None or not host.is_skipped:
            return False
        self._log.log("WARNING", spec.name, f"not started: {host.name} is skipped")
        return True

    def samples(self) -> dict[str, Sample]:
        """The last samples of processes on hosts that can be reached, by name of process."""
        return {name: one for host in self.hosts for name, one in host.current_samples()}

    def host_of(self, spec: ProcessSpec) -> RemoteHost | None:
        """Where it runs; a host that was not planned is connected to now."""
        host = self._plan.host_of(spec)
        if host is None:
            return None
        if host.name not in self._hosts:
            self._add(host).link.open()
        return self._hosts[host.name]

    def order(self, spec: ProcessSpec, host: RemoteHost, *, merge: bool) -> Order:
        """What the host is to run; LaunchFileError."""
        if spec.name in self._plan.orders:
            return self._plan.orders[spec.name]
        defaults = {k: v for k, v in self._defaults.items() if k not in spec.env}
        more = self._plan.environments.get(host.name, {})
        environment = {**defaults, **more, **host.host.environment}
        return order_for(
            spec,
            base=self.run.env,
            environment=environment,
            merge=merge,
            warn=self._log.warn,
        )

    def pause(self, paused: bool) -> None:
        for host in self.hosts:
            host.link.pause(paused)

    def row(self, process: Process) -> Mapping[str, object]:
        """The host, the unit there, since when its rows are not current, and when it was heard."""
        host = None if process.host is None else host_of(process)
        silent_s = None if host is None else host.unreachable_s
        is_placed = host is not None and bool(process.words_there)
        return {
            "host": process.host_name or "local",
            "unit": (host.link.unit(process.process_id) or None) if host and is_placed else None,
            "stop_after_s": None if host is None else host.link.stop_after_s,
            "unreachable_s": None if silent_s is None else round(silent_s, 1),
            "host_silent_s": None if host is None else round(host.link.silent_s, 1),
        }

    # ---- the links

    def link_changed(self, host: RemoteHost, state: LinkState, reason: str) -> None:
        if host.is_gone:
            return
        before, host.state = host.state, state
        self._log.note(LinkChanged(host.name, state.value, reason))
        if host.is_abandoned:
            return
        if host.name in self._connecting:
            is_ready = state is LinkState.READY
            self._answered(host, "" if is_ready else reason or state.value)
        elif state is LinkState.GONE:
            self._gone(host, reason)
        elif before is LinkState.CONNECTING and state is LinkState.UNREACHABLE:
            host.state = LinkState.GONE  # it was not planned, and refuses
            self._gone(host, reason)
        elif state is LinkState.UNREACHABLE:
            self._lost(host, reason)
        elif state is LinkState.READY and before is LinkState.UNREACHABLE:
            self._returned(host)
        self.run.idle()

    def _lost(self, host: RemoteHost, reason: str) -> None:
        host.lost(self._reactor.now())
        names = ", ".join(process.name for process in host.pending)
        running = f"; {host.policy()} ({names})" if names else ""
        because = f": {reason}" if reason else ""
        self._log.warn(f"{host.name} is unreachable{because}{running}")
        if self._is_stopping:
            self._await_return(host)

    def _returned(self, host: RemoteHost) -> None:
        self._timers.cancel(host.name)
        silent_s = self._reactor.now() - host.lost_at_s
        text = f"{host.name} is reachable again after {silent_s:.1f} s: {host.caught_up()}"
        self._log.log("WARNING" if host.dropped else "INFO", "launch", text)

    def _gone(self, host: RemoteHost, reason: str) -> None:
        self._timers.cancel(host.name)
        host.samples = {}
        because = f": {reason}" if reason else ""
        self._log.log("ERROR", "launch", f"{host.name} is lost{because}")
        names = self._driver.lose(host, self._reactor.now())
        if names or host.name in self._finishing:
            self.run.shutdown.host_failed(f"{host.name} was lost")
        self._has_finished(host)

    # ---- the end

    def detach(self) -> list[Process]:
        """Leave the processes on other hosts to them; returns those that run on.

        LauncherError, and nothing is left, if a host cannot.
        """
        used = [host for host in self.hosts if host.pending and not host.is_gone]
        for host in used:
            try:
                host.link.detach()
            except OSError as error:
                raise LauncherError(f"cannot detach from {host.name}: {error}") from None
        left = [process for host in used for process in host.pending]
        self._driver.show_past()
        for host in used:
            host.is_abandoned = True
            self._timers.cancel(host.name)
        for process in left:
            process.abandon(self._reactor.now())
        return left

    def stopping(self) -> None:
        """All processes are being stopped: do not wait for long for hosts that are unreachable."""
        self._is_stopping = True
        for host in self.hosts:
            if host.state in _AWAITED:
                self._await_return(host)

    def skip_grace(self) -> None:
        """Do not wait for hosts that cannot be reached any longer."""
        self._has_skipped = True
        for host in self.hosts:
            if host.state in _AWAITED:
                self._give_up(host)
            elif host.name in self._finishing:
                host.link.finish(at_once=True)

    def _await_return(self, host: RemoteHost) -> None:
        if host.name in self._timers or host.is_abandoned:
            return
        if self._has_skipped:
            self._give_up(host)
            return
        wait_s = LEAVE_S if host.name in self._finishing else host.longest_stop_s
        self._timers.after(host.name, wait_s, functools.partial(self._give_up, host))

    def _give_up(self, host: RemoteHost) -> None:
        if host.is_abandoned:
            return
        self._timers.cancel(host.name)
        host.is_abandoned = True
        names = ", ".join(process.name for process in host.pending)
        for process in host.pending:
            process.abandon(self._reactor.now())
        who = f"{host.name} ({names})" if names else host.name
        after = f"; {host.policy()}" if names else ""
        self._log.log("ERROR", "launch", f"could not be reached: {who}{after}")
        self.run.shutdown.host_failed(f"could not be reached: {who}")
        host.link.finish(at_once=True)
        self._has_finished(host)
        self.run.idle()

    def finish(self, done: Callable[[], None]) -> bool:
        """Have every host stop what is left there; `done` is called when all have."""
        self._done = done
        used = [one for one in self.hosts if not (one.is_abandoned or one.is_gone)]
        if self.is_attaching:
            self._log.log("INFO", "launch", "not attached: the run goes on without this launcher")
            used = []
        waiting = [one for one in used if one.state is not LinkState.CONNECTING]
        self._connecting.clear()
        self._timers.cancel("")
        self._finishing = {host.name for host in waiting}
        for host in used:
            host.link.finish(at_once=self._has_skipped or host not in waiting)
        for host in waiting:
            if host.state is LinkState.UNREACHABLE:
                self._await_return(host)
        self._check_finished()
        return True

    def finished(self, host: RemoteHost, leftovers: Sequence[str], *, killed: bool) -> None:
        for text in leftovers:
            level = "ERROR" if killed else "INFO"
            self._log.log(level, "launch", f"leftover processes on {host.name}: {text}")
        if killed:
            self.run.shutdown.host_failed(f"leftovers on {host.name} had to be killed")
        self._has_finished(host)

    def _has_finished(self, host: RemoteHost) -> None:
        self._timers.cancel(host.name)
        self._finishing.discard(host.name)
        self._check_finished()

    def _check_finished(self) -> None:
        if self._done is not None and not self._finishing:
            done, self._done = self._done, None
            self._reactor.call_later(0, done)

    def conclude(self, *, is_orderly: bool) -> None:
        """Release everything; after an exception the hosts are requested to stop all at once."""
        self._driver.show_past()
        self._timers.close()
        for host in self.hosts:
            if not (is_orderly or self.is_attaching):
                host.link.finish(at_once=True)
            host.link.close()
