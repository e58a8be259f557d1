"""Makes the link to a host, by the engine that its entry in the hosts file asks for."""

from __future__ import annotations

from launcher.hosts.engine.link import Link, LinkContext, LinkState
from launcher.hosts.file.hosts_model import HostEngine

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    from launcher.hosts.file.order import Order
    from launcher.run.processes.machine_events import MachineCommand

    MakeAgent = Callable[[LinkContext], Link]


def make_link(context: LinkContext) -> Link:
    """A link that is not open yet."""
    host = context.host
    if host.engine is HostEngine.SYSTEMD or context.attached is not None:
        from launcher.hosts.engine.systemd.systemd_link import SystemdLink

        return SystemdLink(context)
    if host.engine is HostEngine.AUTO:
        return AutoLink(context, _agent_link)
    return _agent_link(context)


def _agent_link(context: LinkContext) -> Link:
    from launcher.hosts.engine.agent_link import AgentLink, SshTransport

    return AgentLink(context, SshTransport(context.host, context.environment))


class AutoLink:
    """A Link. It tries systemd; what is asked of it until the host has answered is repeated."""

    def __init__(self, context: LinkContext, make_agent: MakeAgent) -> None:
        from launcher.hosts.engine.systemd.systemd_link import SystemdLink

        self._context = context
        self._make_agent = make_agent
        self._asked: list[Callable[[Link], None]] = []
        self._link: Link = SystemdLink(context, on_unusable=self._use_agent)

    def _use_agent(self, reason: str) -> None:
        first, self._link = self._link, self._make_agent(self._context)
        first.close()
        self._link.open()
        for ask in self._asked:
            ask(self._link)
        self._asked.clear()

    def _ask(self, ask: Callable[[Link], None]) -> None:
        if self._link.state is LinkState.CONNECTING:
            self._asked.append(ask)
        ask(self._link)

    @property
    def state(self) -> LinkState:
        return self._link.state

    @property
    def silent_s(self) -> float:
        return self._link.silent_s

    @property
    def stop_after_s(self) -> float | None:
        return self._link.stop_after_s

    def unit(self, process_id: int) -> str:
        return self._link.unit(process_id)

    def open(self) -> None:
        self._link.open()

    def prepare(self, process_id: int, order: Order) -> None:
        self._ask(lambda link: link.prepare(process_id, order))

    def command(self, process_id: int, command: MachineCommand) -> None:
        self._ask(lambda link: link.command(process_id, command))

    def signal(self, process_id: int, signum: int, *, by_user: bool) -> None:
        self._ask(lambda link: link.signal(process_id, signum, by_user=by_user))

    def write_stdin(self, process_id: int, data: bytes) -> None:
        self._ask(lambda link: link.write_stdin(process_id, data))

    def pause(self, paused: bool) -> None:
        self._ask(lambda link: link.pause(paused))

    def finish(self, *, at_once: bool) -> None:
        self._ask(lambda link: link.finish(at_once=at_once))

    def detach(self) -> None:
        self._link.detach()

    def close(self) -> None:
        self._link.close()
