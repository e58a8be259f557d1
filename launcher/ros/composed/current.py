"""The member, one of the programs, to which the running code belongs."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.ros.composed.member import Member

_ATTRIBUTE = "_launcher_member"
_acting = threading.local()


def member() -> Member | None:
    """None in the main thread, and in threads that are not of Python."""
    acting = getattr(_acting, "member", None)
    return acting or getattr(threading.current_thread(), _ATTRIBUTE, None)


@contextlib.contextmanager
def acting_as(one: Member) -> Iterator[None]:
    """What this thread does meanwhile is done for the member."""
    _acting.member = one
    try:
        yield
    finally:
        _acting.member = None


def inherit() -> None:
    """From now on a thread belongs to the member that starts it.

    The member is not interrupted meanwhile: until the new thread runs, Python lists it under
    the identity of the one that starts it, and the exception would end it before it has begun.
    """
    start = threading.Thread.start

    def start_for_member(self: threading.Thread) -> None:
        one = member()
        if not hasattr(self, _ATTRIBUTE):
            belongs_to(self, one)
        if one is None or threading.get_ident() != one.ident:
            start(self)
        else:
            with one.lock:
                start(self)

    threading.Thread.start = start_for_member  # type: ignore[method-assign]


def belongs_to(thread: threading.Thread, one: Member | None) -> None:
    setattr(thread, _ATTRIBUTE, one)
