"""Stops what a process that was stopped, or is restarted, left in its session.

Children of a process that exited by itself may be intended (the parent of a daemon exits); they,
and processes that left the session, run until the end of the run.
"""

from __future__ import annotations

import os
from collections.abc import Callable

from launcher.base.model.spec import StopPolicy
from launcher.posix.reactor import Reactor


def stop_session(
    session: int,
    *,
    run_id: str,
    reactor: Reactor,
    ignore: frozenset[int],
    stop: StopPolicy,
    log: Callable[[str, str], None],
    killing: Callable[[], None],
) -> None:
    """`stop` is the policy of the process; `log` gets levels and texts."""
    if not _has_members(session):
        return
    from launcher.run.ending.leftovers import Leftovers, stop_policy_for

    Leftovers(
        run_id,
        reactor=reactor,
        listener=_Listener(log, killing),
        ignore=ignore,
        policy=stop_policy_for((stop,)),
        session=session,
    ).check()


class _Listener:
    def __init__(self, log: Callable[[str, str], None], killing: Callable[[], None]) -> None:
        self.report = log
        self.killing = killing

    def finished(self) -> None: ...


def _has_members(group: int) -> bool:
    """Whether this process group has a member; its number is not reused before."""
    try:
        os.killpg(group, 0)
    except OSError:
        return False
    return True
