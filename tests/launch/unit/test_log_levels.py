"""--log-level: the values of the option, and the command lines that they make."""

from __future__ import annotations

import pytest

from launcher.base.errors import UsageError
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import ProcessSpec, RosIdentity
from launcher.launch.process_options import parse_log_levels
from launcher.run.option_warnings import unmatched, without_node


def spec(*words: str, name: str = "robot_1", is_node: bool = True) -> ProcessSpec:
    ros = RosIdentity(node_name=f"/fleet/{name}") if is_node else None
    return ProcessSpec(name=f"{name}-1", label=name, argv=("prog", *words), env={}, ros=ros)


def options(word: str) -> RunOptions:
    return RunOptions(log_levels=tuple(setting for _, setting in parse_log_levels(word)))


def levels(word: str, *words: str, name: str = "robot_1") -> list[str]:
    """The words behind the program."""
    return list(options(word).adapt(spec(*words, name=name)).argv[1:])


@pytest.mark.parametrize(
    ("word", "level"),
    [
        ("robot_1=debug", "debug"),
        ("robot_1=debug,*=warn", "debug"),
        ("*=error,robot_1=debug,robot_*=warn", "debug"),
        ("*=error,robot_*=warn", "warn"),
        ("robot_*=warn,*=error", "warn"),
        ("robot_*=warn,robot_?=fatal", "fatal"),
        ("robot_1-1=info", "info"),
        ("/fleet/robot_1=info", "info"),
        ("*=WARNING", "warn"),
        ("*=Debug", "debug"),
    ],
)
def test_a_name_counts_before_a_pattern_and_that_before_all(word, level):
    assert levels(word) == ["--ros-args", "--log-level", level]


def test_a_level_of_the_process_replaces_all_of_the_launch_file():
    own = ["--log-level", "x", "--ros-args", "--log-level", "info", "-r", "a:=b"]
    own += ["--log-level", "rcl:=error", "--", "--log-level", "y"]
    expected = ["--log-level", "x", "--ros-args", "-r", "a:=b", "--", "--log-level", "y"]
    assert levels("*=warn", *own) == [*expected, "--ros-args", "--log-level", "warn"]


def test_a_level_of_a_logger_replaces_only_its_own():
    own = ["--ros-args", "--log-level", "info", "--log-level", "rcl:=error"]
    made = levels("robot_1:rcl=debug,*:rmw=fatal", *own)
    added = ["--log-level", "rmw:=fatal", "--log-level", "rcl:=debug"]
    assert made == ["--ros-args", "--log-level", "info", "--ros-args", *added]


def test_other_processes_stay_as_they_are():
    other = spec("--ros-args", name="monitor")
    assert options("robot_*=warn").adapt(other) == other
    program = spec(is_node=False)
    assert options("*=warn").adapt(program) == program


@pytest.mark.parametrize(
    ("word", "problem", "hint"),
    [
        ("robot_1=debgu", "unknown level 'debgu'", "did you mean 'debug'?"),
        ("robot_1=7", "unknown level '7'", "known: debug, info, warn, error, fatal"),
        ("robot_1=", "unknown level ''", "known: debug"),
        ("debug", "expected NAME=LEVEL", "--log-level '*=debug'"),
        ("robot_1", "expected NAME=LEVEL", "for example"),
        ("robot_1=debug,", "expected NAME=LEVEL", "for example"),
        ("=debug", "expected NAME=LEVEL", "'*=debug'"),
        ("robot_1:=debug", "'' is not the name of a logger", "for example"),
        ("robot_1:a b=debug", "'a b' is not the name of a logger", "for example"),
    ],
)
def test_mistakes_name_the_part_and_a_repair(word, problem, hint):
    with pytest.raises(UsageError) as error:
        parse_log_levels(word)
    assert problem in error.value.message
    assert error.value.hint is not None and hint in error.value.hint


def test_a_pattern_without_a_node_is_told():
    given = options("robto_1=debug,sh*=info,*=warn")
    specs = [spec(), spec(name="sh", is_node=False)]
    assert unmatched(given, specs) == [
        ("--log-level 'robto_1' matches no process", " (did you mean 'robot_1'?)")
    ]
    assert without_node(given, specs) == [
        "--log-level 'sh*' does not apply to sh-1: it is not started as a ROS node"
    ]
