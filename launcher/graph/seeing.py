"""Seeing: the look at the graph that a verb gets, by the quickest way there is."""

from __future__ import annotations

from launcher.command_line import Parsed
from launcher.graph import domains
from launcher.graph.ask import look_of_a_run
from launcher.graph.look import Look
from launcher.graph.verb import domain_option, settled, spin_time_s, tell_what_is_missing


def seen(options: Parsed) -> Look:
    """The graph of the domain that is asked for; what could not be seen is said on stderr."""
    if not options.no_observer and (look := look_of_a_run(domain_option(options))):
        tell_what_is_missing(look.domain_id, look.nodes, 0, 0.0)
        return look
    if domains.is_plain() and (look := _by_wire(options)):
        return look
    with settled(options) as observer:
        return observer.look()


def _by_wire(options: Parsed) -> Look | None:
    """None if it takes a whole DDS stack."""
    from launcher.graph.wire import Unfit, look_round

    domain_id = domain_option(options)
    remote = not domains.localhost_only()
    try:
        found = look_round(domain_id, spin_time_s(options), remote=remote)
    except (Unfit, OSError):
        return None
    tell_what_is_missing(domain_id, found.look.nodes, found.missing, found.waited_s)
    return found.look
