"""`launch.logging`: loggers that hand their records to the run, and how its lines are formatted."""

from __future__ import annotations

import logging
import os

from launcher.language import launch_session
from launcher.language.logging import handlers
from launcher.language.logging.handlers import SessionHandler
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

_ROOT = "launch"
_SCREEN_FORMAT = "[{levelname}] [{name}]: {message}"
_FILE_FORMAT = "{created:.7f} [{levelname}] [{name}]: {message}"
_ALIASES = {"default": _SCREEN_FORMAT, "default_with_timestamp": _FILE_FORMAT}
_loggers: dict[str, logging.Logger] = {}  # that this module has configured


@public("launch.logging")
class LaunchConfig:
    """Level, formats and files of the messages of the launch, also of the launcher's own."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Back to the defaults, which the environment variables of ROS 2 change."""
        self._level: int | None = None
        self._factory: Callable[..., logging.Handler] | None = None
        self._screen_handler: SessionHandler | None = None
        self.file_handlers: dict[str, logging.Handler] = {}
        self._log_file_name: str | None = None
        self.set_screen_format("default")
        self.set_log_format("default")
        if launch_session.current().prints:
            self.log_dir = None
            launch_session.current().forget_log_dir()
        launch_session.current().formats = self if self._is_changed else None

    @property
    def log_file_name(self) -> str:
        """The file with all lines."""
        return self._log_file_name or f"{launch_session.current().log_name}.log"

    @log_file_name.setter
    def log_file_name(self, log_file_name: str) -> None:
        self._log_file_name = log_file_name

    # ---- level

    @property
    def level(self) -> int:
        """The least level that is logged; INFO, or DEBUG with `--debug`."""
        usual = logging.DEBUG if launch_session.current().is_debug else logging.INFO
        return usual if self._level is None else self._level

    @level.setter
    def level(self, new_level: int | str) -> None:
        self._level = logging._checkLevel(new_level)  # type: ignore[attr-defined]
        for logger in _loggers.values():
            logger.setLevel(self._level)
        self._changed()

    # ---- formats

    def set_screen_format(self, screen_format: str, *, screen_style: str | None = None) -> None:
        """A format of `logging.Formatter`, `default` or `default_with_timestamp`.

        ValueError for an invalid format, and for a style with one of these two names.
        `OVERRIDE_LAUNCH_SCREEN_FORMAT` takes precedence.
        """
        variable = "OVERRIDE_LAUNCH_SCREEN_FORMAT"
        self.screen_formatter = _formatter(variable, screen_format, screen_style, _ALIASES)
        self._own_screen_format = _is_other(self.screen_formatter, _SCREEN_FORMAT)
        if self._screen_handler is not None:
            self._screen_handler.setFormatter(self.screen_formatter)
            self._screen_handler.formatted = self._own_screen_format
        self._changed()

    def set_log_format(self, log_format: str, *, log_style: str | None = None) -> None:
        """The same for log files, where `default` has a time stamp; `OVERRIDE_LAUNCH_LOG_FORMAT`
        takes precedence.
        """
        variable = "OVERRIDE_LAUNCH_LOG_FORMAT"
        aliases = {"default": _FILE_FORMAT}
        self.file_formatter = _formatter(variable, log_format, log_style, aliases)
        self._own_file_format = _is_other(self.file_formatter, _FILE_FORMAT)
        for handler in self.file_handlers.values():
            handler.setFormatter(self.file_formatter)
            if isinstance(handler, SessionHandler):
                handler.formatted = self._own_file_format
        self._changed()

    # ---- handlers

    def get_screen_handler(self) -> logging.Handler:
        """The only handler for the screen."""
        if self._screen_handler is None:
            self._screen_handler = SessionHandler("screen")
            self._screen_handler.setFormatter(self.screen_formatter)
            self._screen_handler.formatted = self._own_screen_format
        return self._screen_handler

    @property
    def log_handler_factory(self) -> Callable[..., logging.Handler]:
        """Makes the handler of a log file, from `(path, encoding=...)`."""
        factory: Callable[..., logging.Handler] = self._factory or handlers.WatchedFileHandler
        return factory

    @log_handler_factory.setter
    def log_handler_factory(self, new_log_handler_factory: Callable[..., logging.Handler]) -> None:
        self._factory = new_log_handler_factory
        self._changed()

    def get_log_file_handler(self, file_name: str = "launch.log") -> logging.Handler:
        """The handler of a log file, always the same one."""
        if file_name not in self.file_handlers:
            self.file_handlers[file_name] = made = self._file_handler(file_name)
            made.setFormatter(self.file_formatter)
        return self.file_handlers[file_name]

    def _file_handler(self, file_name: str) -> logging.Handler:
        current = launch_session.current()
        is_main = file_name in ("launch.log", f"{current.log_name}.log")
        if self._factory is None and is_main and not current.prints:
            handler = SessionHandler("log")  # the run itself writes this file
            handler.formatted = self._own_file_format
            return handler
        path = self.get_log_file_path(file_name)
        if self._factory is None:
            os.makedirs(os.path.dirname(path), exist_ok=True)
        return self.log_handler_factory(path, encoding="utf-8")

    # ---- files

    @property
    def log_dir(self) -> str:
        """The folder of this run's log files."""
        return launch_session.current().log_dir

    @log_dir.setter
    def log_dir(self, new_log_dir: str | None) -> None:
        """ValueError unless it is a folder; None for the usual one."""
        if new_log_dir is not None and not os.path.isdir(new_log_dir):
            raise ValueError(f"{new_log_dir} is not a directory")
        launch_session.current().log_dir = new_log_dir

    def get_log_file_path(self, file_name: str = "launch.log") -> str:
        return os.path.join(self.log_dir, file_name)

    # ---- the launcher's own messages

    @property
    def _is_changed(self) -> bool:
        is_own_format = self._own_screen_format or self._own_file_format
        return is_own_format or self._factory is not None or self._level is not None

    def _changed(self) -> None:
        if hasattr(self, "_own_file_format") and self._is_changed:
            launch_session.current().formats = self

    def screen_line(self, level: str, logger: str, text: str) -> str | None:
        """The line to print, "" for the usual one, None for none."""
        record = self._record(level, logger, text)
        if record is None or not self._own_screen_format:
            return None if record is None else ""
        return _formatted(self.screen_formatter, record)

    def file_line(self, level: str, logger: str, text: str) -> str | None:
        """The same for `launch.log`; a handler of the launch file's own gets the message."""
        record = self._record(level, logger, text)
        if record is None:
            return None
        if self._factory is not None:
            self.get_log_file_handler(self.log_file_name).handle(record)
            return None
        return _formatted(self.file_formatter, record) if self._own_file_format else ""

    def _record(self, level: str, logger: str, text: str) -> logging.LogRecord | None:
        number = logging.getLevelName(level)
        number = number if isinstance(number, int) else logging.INFO
        if number < self.level:
            return None
        return logging.LogRecord(logger, number, "", 0, text, None, None)


def _formatter(
    variable: str, given: str, style: str | None, aliases: dict[str, str]
) -> logging.Formatter:
    override = os.environ.get(variable)
    if override:
        given, style = override.encode("latin1", "replace").decode("unicode_escape"), "{"
    if given in aliases and style is not None:
        source = f" ({variable})" if override else ""
        raise ValueError(f"Cannot set a custom format style for the {given!r} format{source}")
    try:
        return logging.Formatter(aliases.get(given, given), style=style or "{")  # type: ignore[arg-type]
    except ValueError as error:
        raise ValueError(f"{variable}: {error}") if override else error from None


def _is_other(formatter: logging.Formatter, usual: str) -> bool:
    return formatter._fmt != usual


def _formatted(formatter: logging.Formatter, record: logging.LogRecord) -> str:
    """The line; "" for the usual one if the format has an unknown field."""
    try:
        return formatter.format(record)
    except (KeyError, ValueError):
        return ""


launch_config = LaunchConfig()


def get_logger(name: str | None = None) -> logging.Logger:
    """A logger for the screen and `launch.log`."""
    logger = _configured(logging.getLogger(_ROOT if name is None else name))
    logger.addHandler(launch_config.get_screen_handler())
    logger.addHandler(launch_config.get_log_file_handler(launch_config.log_file_name))
    return logger


def _configured(logger: logging.Logger) -> logging.Logger:
    if logger.name not in _loggers:
        _loggers[logger.name] = logger
        logger.propagate = False
        if logger.level == logging.NOTSET:
            logger.setLevel(launch_config.level)
    return logger


def get_output_loggers(
    process_name: str, output_config: object, *, main_log_file_name: str = "launch.log"
) -> tuple[logging.Logger, logging.Logger]:
    """(stdout logger, stderr logger) of a process; ValueError for an unknown configuration."""
    both, stdout, stderr = _destinations(output_config)
    return (
        _output_logger(process_name, "stdout", both, stdout, main_log_file_name),
        _output_logger(process_name, "stderr", both, stderr, main_log_file_name),
    )


_NAMED = {
    "screen": ({"screen"}, set(), set()),
    "log": ({"log"}, set(), {"screen"}),
    "both": ({"log", "screen"}, set(), set()),
    "own_log": ({"own_log"}, {"own_log"}, {"own_log"}),
    "full": ({"screen", "log", "own_log"}, {"own_log"}, {"own_log"}),
}


def _destinations(config: object) -> tuple[set[str], set[str], set[str]]:
    """Where the output of both streams, of stdout and of stderr goes."""
    from launcher.language.actions.output import output_policy

    if not isinstance(config, (str, dict)):
        raise ValueError(f"{config} is not a valid output configuration")
    output_policy(config)  # refuses unknown words
    if isinstance(config, str):
        return _NAMED[config]
    both, stdout, stderr = (config.get(key, ()) for key in ("both", "stdout", "stderr"))
    return _words(both), _words(stdout), _words(stderr)


def _words(given: Any) -> set[str]:
    return {given} if isinstance(given, str) else set(given)


def _output_logger(
    process: str, stream: str, both: set[str], own: set[str], main_file: str
) -> logging.Logger:
    logger = _configured(logging.getLogger(f"{process}-{stream}"))
    if "screen" in both | own:
        _add(logger, launch_config.get_screen_handler(), "{message}")
    if "log" in both | own:
        _add(logger, launch_config.get_log_file_handler(main_file), "{created:.7f} {message}")
    if "own_log" in own:
        _add(logger, launch_config.get_log_file_handler(f"{process}-{stream}.log"), "{message}")
    if "own_log" in both:
        _add(logger, launch_config.get_log_file_handler(f"{process}.log"), "{message}")
    return logger


def _add(logger: logging.Logger, handler: logging.Handler, pattern: str) -> None:
    formatter = logging.Formatter(pattern, style="{")
    if hasattr(handler, "setFormatterFor"):
        handler.setFormatterFor(logger, formatter)
    else:
        handler.setFormatter(formatter)
    logger.addHandler(handler)


def log_launch_config(*, logger: logging.Logger | None = None) -> None:
    """Log where the log files are."""
    (get_logger() if logger is None else logger).info(
        "All log files can be found below %s", launch_config.log_dir
    )


def reset() -> None:
    """Reset `launch_config`, and take the handlers from all loggers."""
    for logger in _loggers.values():
        logger.setLevel(logging.NOTSET)
        logger.handlers.clear()
    _loggers.clear()
    for handler in launch_config.file_handlers.values():
        handler.close()
    launch_config.reset()


@public("launch.logging")
class LaunchLogger(logging.Logger):
    """For launch files that name ROS 2's class; `get_logger` returns plain loggers."""
