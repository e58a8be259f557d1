"""Makes the link to a host, by the engine that its entry in the hosts file asks for."""

from __future__ import annotations

from launcher.hosts.engine.link import Link, LinkContext
from launcher.hosts.file.model import HostEngine


def make_link(context: LinkContext) -> Link:
    """A link that is not open yet."""
    host = context.host
    if host.engine is HostEngine.SYSTEMD or context.attached is not None:
        from launcher.hosts.engine.systemd.link import SystemdLink

        return SystemdLink(context)
    if host.engine is HostEngine.AUTO:
        from launcher.hosts.engine.auto_link import AutoLink

        return AutoLink(context, _agent_link)
    return _agent_link(context)


def _agent_link(context: LinkContext) -> Link:
    from launcher.hosts.engine.agent_link import AgentLink
    from launcher.hosts.engine.transport import SshTransport

    return AgentLink(context, SshTransport(context.host, context.environment))
