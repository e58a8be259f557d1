"""`launch.logging`: levels, formats, handlers and files, in a script and in a run."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from launcher.base.model.events import LogMessage
from launcher.language.actions.event_actions import LogInfo, OpaqueFunction
from launcher.language.compat import vocabulary
from launcher.language.launch_session import LaunchSession
from launcher.run.logs.run_log import RunLog
from tests.language.unit.interpreter.interpreting import interpreting


@pytest.fixture
def log(monkeypatch, tmp_path: Path) -> Iterator[Any]:
    """`launch.logging` in a script, with its log folder in `tmp_path`."""
    for name in ("OVERRIDE_LAUNCH_SCREEN_FORMAT", "OVERRIDE_LAUNCH_LOG_FORMAT"):
        monkeypatch.delenv(name, raising=False)
    with vocabulary() as session:
        session.is_script = True
        import launch.logging

        launch.logging.reset()
        launch.logging.launch_config.log_dir = str(tmp_path)
        yield launch.logging


def written(log: Any, name: str = "launch.log") -> list[str]:
    log.launch_config.get_log_file_handler(name).flush()
    return Path(log.launch_config.get_log_file_path(name)).read_text().splitlines()


# ---- in a script


def test_a_reset_forgets_the_log_folder(log, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "usual"))
    assert log.launch_config.log_dir == str(tmp_path)
    log.reset()
    assert log.launch_config.log_dir == str(tmp_path / "usual")


def test_a_logger_prints_and_writes_its_file_once(log, capsys):
    logger = log.get_logger("some")
    logger.addHandler(log.launch_config.get_screen_handler())
    logger.addHandler(log.launch_config.get_log_file_handler())

    logger.debug("no")
    logger.info("yes")

    assert capsys.readouterr().out == "[INFO] [some]: yes\n"
    (line,) = written(log)
    assert re.fullmatch(r"\d+\.\d{7} \[INFO\] \[some\]: yes", line)


def test_the_level_is_that_of_all_loggers(log, capsys):
    before = log.get_logger("before")
    log.launch_config.level = logging.DEBUG
    after = log.get_logger("after")

    before.debug("1")
    after.debug("2")

    assert log.launch_config.level == logging.DEBUG == before.getEffectiveLevel()
    assert capsys.readouterr().out == "[DEBUG] [before]: 1\n[DEBUG] [after]: 2\n"


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ({"screen_format": "default_with_timestamp"}, r"\d+\.\d{7} \[INFO\] \[x\]: text"),
        ({"screen_format": "<{name}> {message}"}, "<x> text"),
        ({"screen_format": "<%(name)s>", "screen_style": "%"}, "<x>"),
    ],
)
def test_a_screen_format_also_applies_to_handlers_that_exist(given, line, log, capsys):
    logger = log.get_logger("x")

    log.launch_config.set_screen_format(**given)
    logger.info("text")

    assert re.fullmatch(line, capsys.readouterr().out.strip())


def test_a_log_format_is_for_files_only(log, capsys):
    log.launch_config.set_log_format("<{name}> {message}")

    log.get_logger("x").info("text")

    assert written(log) == ["<x> text"]
    assert capsys.readouterr().out == "[INFO] [x]: text\n"


def test_the_variables_win_over_formats(log, capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("OVERRIDE_LAUNCH_SCREEN_FORMAT", "S {message}\\t{name}")
    monkeypatch.setenv("OVERRIDE_LAUNCH_LOG_FORMAT", "F {message}")
    log.reset()
    log.launch_config.set_screen_format("{message}")

    log.get_logger("x").info("text")

    assert capsys.readouterr().out == "S text\tx\n"
    assert written(log) == ["F text"]


@pytest.mark.parametrize(
    "wrong",
    [
        lambda config: config.set_screen_format("default", screen_style="%"),
        lambda config: config.set_log_format("default", log_style="{"),
        lambda config: config.set_screen_format("no field"),
        lambda config: setattr(config, "log_dir", "not/a/folder"),
        lambda config: setattr(config, "level", "nonsense"),
    ],
)
def test_wrong_settings_are_refused(wrong, log):
    with pytest.raises(ValueError):
        wrong(log.launch_config)


def test_a_factory_makes_the_handlers_of_files(log):
    made: dict[str, list[str]] = {}

    class Keeping(log.handlers.Handler):
        def __init__(self, path: str, encoding: str | None = None) -> None:
            super().__init__()
            self.lines = made.setdefault(path, [])

        def emit(self, record: logging.LogRecord) -> None:
            self.lines.append(self.format(record))

    log.launch_config.log_handler_factory = Keeping
    log.get_logger("x").info("text")

    ((path, lines),) = made.items()
    assert path == log.launch_config.get_log_file_path()
    assert len(lines) == 1
    assert lines[0].endswith("[INFO] [x]: text")


@pytest.mark.parametrize(
    ("config", "screen", "main", "own"),
    [
        ("screen", "ab", "", {}),
        ("log", "b", "ab", {}),
        ("both", "ab", "ab", {}),
        ("own_log", "", "", {"p-stdout.log": "a", "p-stderr.log": "b", "p.log": "ab"}),
        ("full", "ab", "ab", {"p-stdout.log": "a", "p-stderr.log": "b", "p.log": "ab"}),
        ({"stdout": "screen", "stderr": {"own_log"}}, "a", "", {"p-stderr.log": "b"}),
    ],
)
def test_the_output_of_a_process_goes_where_its_configuration_says(
    config, screen, main, own, log, capsys, tmp_path
):
    stdout, stderr = log.get_output_loggers("p", config)

    stdout.info("a")
    stderr.info("b")

    assert capsys.readouterr().out.split() == list(screen)
    files = {path.name: path.read_text() for path in tmp_path.glob("*.log")}
    assert "".join(re.findall(r"[0-9.]+ ([ab])\n", files.pop("launch.log", ""))) == main
    assert {name: text.replace("\n", "") for name, text in files.items()} == own


@pytest.mark.parametrize("config", ["nonsense", {"nonsense": "log"}, {"stdout": {"nonsense"}}, 5])
def test_an_unknown_output_configuration_is_refused(config, log):
    with pytest.raises(ValueError):
        log.get_output_loggers("p", config)


def test_a_reset_takes_handlers_and_levels_back(log, capsys):
    logger = log.get_logger("x")
    log.launch_config.level = logging.ERROR
    log.launch_config.set_screen_format("{message}")

    log.reset()
    logger.info("nobody hears")
    log.get_logger("x").info("usual")

    assert log.launch_config.level == logging.INFO
    assert capsys.readouterr().out == "[INFO] [x]: usual\n"


def test_a_handler_has_formatters_of_single_loggers(log, capsys):
    handler, logger = log.launch_config.get_screen_handler(), log.get_logger("x")
    handler.setFormatterFor(logger, logging.Formatter("only {message}", style="{"))
    logger.info("this")
    handler.unsetFormatterFor(logger)
    logger.info("that")

    assert capsys.readouterr().out == "only this\n[INFO] [x]: that\n"
    assert issubclass(log.handlers.RotatingFileHandler, logging.handlers.RotatingFileHandler)


# ---- in a run


def messages(function: Any) -> list[LogMessage]:
    with interpreting([OpaqueFunction(function=function), LogInfo(msg="end")]) as interpreter:
        return [effect for effect in interpreter.start() if isinstance(effect, LogMessage)]


def test_a_message_of_a_run_goes_to_both_places_once():
    def say(context: Any) -> None:
        import launch.logging

        logger = launch.logging.get_logger("x")
        logger.addHandler(launch.logging.launch_config.get_screen_handler())
        logger.info("said %s", "once")

    seen = [m for m in messages(say) if m.logger != "launch"]
    found = [(m.logger, m.text, m.sink, m.line) for m in seen]

    assert found == [
        ("x", "said once", "screen", None),
        ("x", "said once", "log", None),
        ("launch.user", "end", "", None),
    ]


class _Lines:
    """In the place of the screen or the log folder."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def log(self, level: str, logger: str, text: str) -> None:
        self.lines.append(f"usual {level} {logger} {text}")

    def log_line(self, line: str) -> None:
        self.lines.append(line)

    def now(self) -> float:
        return 0.0


def lines_of(session: LaunchSession) -> tuple[list[str], list[str]]:
    screen, files = _Lines(), _Lines()
    log: Any = RunLog(_Lines(), screen, files, session)  # type: ignore[arg-type]
    log.log("INFO", "node-1", "process started")
    log.log("ERROR", "node-1", "process has died")
    return screen.lines, files.lines


def test_the_lines_of_the_launcher_follow_the_formats_and_the_level():
    with vocabulary() as session:
        import launch.logging

        usual = ["usual INFO node-1 process started", "usual ERROR node-1 process has died"]
        assert lines_of(session) == (usual, usual)
        launch.logging.launch_config.set_screen_format("{name}: {message}")
        launch.logging.launch_config.level = logging.ERROR
        assert lines_of(session) == (["node-1: process has died"], usual[1:])
        launch.logging.launch_config.set_log_format("{nonsense}")  # the usual one is left
        assert lines_of(session)[1] == usual[1:]

    with vocabulary() as session:
        assert lines_of(session) == (usual, usual)


def test_a_factory_of_the_launch_file_gets_the_lines_of_the_launcher(tmp_path):
    with vocabulary() as session:
        import launch.logging

        session.log_dir = str(tmp_path)
        launch.logging.launch_config.log_handler_factory = launch.logging.handlers.FileHandler

        assert lines_of(session)[1] == []
        assert len(written(launch.logging)) == 2
