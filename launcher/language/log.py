"""`launch.logging`: loggers that hand their records to the session."""

from __future__ import annotations

import logging

from launcher.language import session
from launcher.language.actions.output import output_policy
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_ROOT = "launch"
_LEVELS = {"WARN": "WARNING", "FATAL": "CRITICAL"}


class SessionHandler(logging.Handler):
    """Hands records to the session of the vocabulary that is open."""

    def emit(self, record: logging.LogRecord) -> None:
        level = _LEVELS.get(record.levelname, record.levelname)
        session.current().log(record.name, level, record.getMessage())


@public("launch.logging")
class LaunchConfig:
    """Settings of log files; only `log_dir` has an effect."""

    def __init__(self) -> None:
        self.level: int | str = logging.INFO
        self.log_file_name = "launch.log"
        self.log_handler_factory: Any = None

    @property
    def log_dir(self) -> str:
        """The folder of this run's log files."""
        return session.current().log_dir

    @log_dir.setter
    def log_dir(self, new_log_dir: str | None) -> None:
        session.current().log_dir = new_log_dir

    def reset(self) -> None:
        self.__init__()  # type: ignore[misc]

    def set_screen_format(self, screen_format: str, *, screen_style: str | None = None) -> None:
        """No effect: the launcher formats the lines."""

    def set_log_format(self, log_format: str, *, log_style: str | None = None) -> None:
        """No effect: the launcher formats the lines."""

    def get_log_file_path(self, file_name: str = "launch.log") -> str:
        return f"{self.log_dir}/{file_name}"

    def get_screen_handler(self) -> logging.Handler:
        """The handler of every logger here."""
        return SessionHandler()

    def get_log_file_handler(self, file_name: str = "launch.log") -> logging.Handler:
        """The handler of every logger here."""
        return SessionHandler()


launch_config = LaunchConfig()


def get_logger(name: str | None = None) -> logging.Logger:
    """A logger that hands its records to the session."""
    logger = logging.getLogger(_ROOT if name is None else name)
    if not any(isinstance(handler, SessionHandler) for handler in logger.handlers):
        logger.addHandler(SessionHandler())
        logger.propagate = False
        if logger.level == logging.NOTSET:
            logger.setLevel(logging.INFO)
    return logger


def get_output_loggers(
    process_name: str, output_config: Any, *, main_log_file_name: str = "launch.log"
) -> tuple[logging.Logger, logging.Logger]:
    """(stdout logger, stderr logger) of a process; ValueError for an unknown configuration."""
    output_policy(output_config)
    return (
        logging.getLogger(f"{process_name}-stdout"),
        logging.getLogger(f"{process_name}-stderr"),
    )


def log_launch_config(*, logger: logging.Logger | None = None) -> None:
    """Log where the log files are."""
    (get_logger() if logger is None else logger).info(
        "All log files can be found below %s", launch_config.log_dir
    )


def reset() -> None:
    """Reset `launch_config`."""
    launch_config.reset()


@public("launch.logging")
class LaunchLogger(logging.Logger):
    """For launch files that name ROS 2's class; `get_logger` returns plain loggers."""
