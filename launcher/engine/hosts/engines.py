"""Makes the link to a host, by the engine that its entry in the hosts file asks for."""

from __future__ import annotations

from launcher.engine.hosts.link import Link, LinkContext
from launcher.hosts.model import HostEngine


def make_link(context: LinkContext) -> Link:
    """A link that is not open yet."""
    host = context.host
    if host.engine is HostEngine.SYSTEMD or context.attached is not None:
        from launcher.engine.hosts.systemd.link import SystemdLink

        return SystemdLink(context)
    if host.engine is HostEngine.AUTO:
        from launcher.engine.hosts.auto_link import AutoLink

        return AutoLink(context, _agent_link)
    return _agent_link(context)


def _agent_link(context: LinkContext) -> Link:
    from launcher.engine.hosts.agent_link import AgentLink
    from launcher.engine.hosts.transport import SshTransport

    return AgentLink(context, SshTransport(context.host, context.environment))
