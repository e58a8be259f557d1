"""What of the arguments of a composed program applies to its nodes."""

from __future__ import annotations

import pytest

from launcher.ros.composed.member_arguments import log_levels, node_arguments


def test_words_of_ros_are_those_of_the_node_without_levels():
    words = ["prog", "-x", "--ros-args", "-r", "a:=b", "--log-level", "debug", "--", "-p", "no:=1"]
    words += ["--ros-args", "-p", "yes:=1"]
    assert node_arguments(words) == ["--ros-args", "-r", "a:=b", "-p", "yes:=1", "--"]
    assert node_arguments(["prog", "--log-level", "x"]) == []


def test_levels_are_those_of_the_node_or_of_a_logger():
    words = ["prog", "--log-level", "x", "--ros-args", "--log-level", "DEBUG"]
    words += ["--log-level", "rcl:=error"]
    assert log_levels(words) == [("", 10), ("rcl", 40)]
    with pytest.raises(RuntimeError, match="Couldn't parse log level: '--log-level WARNING'"):
        log_levels(["--ros-args", "--log-level", "WARNING"])
