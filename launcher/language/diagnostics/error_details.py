"""What is known about an exception of a launch file, for its report."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.diagnostics.origin import FileLine

_ATTRIBUTE = "_launcher_details"


class ErrorDetails:
    """Replaces what `faults.explain` would find itself; None: it has to.

    `word` is what the message points at in the line; `entity` was visited when the error was
    raised.
    """

    def __init__(self) -> None:
        self.message: str | None = None
        self.place: FileLine | None = None
        self.hint: str | None = None
        self.word: str | None = None
        self.entity: object = None


def details(error: BaseException) -> ErrorDetails:
    """Those of this exception; what is set there stays with it."""
    known: ErrorDetails = vars(error).setdefault(_ATTRIBUTE, ErrorDetails())
    return known
