"""`launch.logging.handlers`: Python's handlers, each with formatters for single loggers."""

from __future__ import annotations

import logging
import sys
from logging import handlers as _handlers

from launcher.language import launch_session

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    _Handler = logging.Handler
else:
    _Handler = object


class PerLogger(_Handler):
    """Formats the records of some loggers differently."""

    def setFormatterFor(self, logger: logging.Logger, formatter: logging.Formatter) -> None:
        """Use this formatter for records of the logger."""
        self._formatters()[logger.name] = formatter

    def unsetFormatterFor(self, logger: logging.Logger) -> None:
        """Use the common formatter again."""
        self._formatters().pop(logger.name, None)

    def format(self, record: logging.LogRecord) -> str:
        formatter = self._formatters().get(record.name)
        return super().format(record) if formatter is None else formatter.format(record)

    def _formatters(self) -> dict[str, logging.Formatter]:
        found: dict[str, logging.Formatter] = self.__dict__.setdefault("_of_loggers", {})
        return found


def __getattr__(name: str) -> Any:
    """Any class of `logging` and `logging.handlers`, with PerLogger."""
    original = getattr(_handlers, name, None) or getattr(logging, name, None)
    if not (isinstance(original, type) and issubclass(original, logging.Handler)):
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    made = globals()[name] = type(name, (PerLogger, original), {})
    return made


class SessionHandler(PerLogger, logging.Handler):
    """Hands records to the run, or prints them if none is there, as in a script before `run`.

    `sink` is `screen` or `log`: a logger may have only one of the two. With `formatted`, the run
    prints the line as formatted here; else it formats the line itself, with its colours.
    """

    def __init__(self, sink: str) -> None:
        super().__init__()
        self._sink = sink
        self.formatted = False

    def emit(self, record: logging.LogRecord) -> None:
        current = launch_session.current()
        if current.prints:
            try:
                sys.stdout.write(self.format(record) + "\n")
                sys.stdout.flush()
            except Exception:
                self.handleError(record)
            return
        level = launch_session.LEVEL_NAMES.get(record.levelname, record.levelname)
        line = self.format(record) if self.formatted or record.name in self._formatters() else None
        current.log(record.name, level, record.getMessage(), sink=self._sink, line=line)
