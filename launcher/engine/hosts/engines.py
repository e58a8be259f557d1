"""Makes the link to a host, by the engine that its entry in the hosts file asks for."""

from __future__ import annotations

from launcher.engine.hosts.link import Link, LinkContext
from launcher.errors import UsageError
from launcher.hosts.model import HostEngine


def make_link(context: LinkContext) -> Link:
    """A link that is not open yet; UsageError if there is no such engine."""
    host = context.host
    if host.engine in (HostEngine.SSH, HostEngine.AUTO):
        from launcher.engine.hosts.agent_link import AgentLink
        from launcher.engine.hosts.transport import SshTransport

        return AgentLink(context, SshTransport(host, context.environment))
    raise UsageError(f"host '{host.name}': the engine '{host.engine.value}' is not available")
