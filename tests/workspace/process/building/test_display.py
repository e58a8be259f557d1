"""What a build shows in a terminal, and how interfaces are built."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from tests.support.screen_terminal import ScreenTerminal
from tests.workspace.process.building.small_packages import (
    COMMAND,
    built,
    cmake_package,
    message_package,
    write,
)


def test_a_terminal_shows_package_step_and_time(tmp_path: Path):
    cmake_package(tmp_path / "src", "slow", "execute_process(COMMAND sleep 1000)")
    env = {**os.environ, "TERM": "xterm"}
    with ScreenTerminal(COMMAND, env=env, cwd=tmp_path) as terminal:
        terminal.wait_until(
            lambda: re.search(r"\[0/1\] \d+ s  slow: configure", terminal.text), "the line"
        )
        terminal.ctrl_c()
        assert terminal.exit_code() == 130

    assert "interrupted: the next build continues" in terminal.text


@pytest.mark.thorough
def test_interfaces_of_packages_that_depend_on_each_other(tmp_path: Path):
    """Below a folder with an umlaut; a removed message leaves nothing behind."""
    root = tmp_path / "Übung 1"
    message_package(root / "src", "lower")
    upper = message_package(
        root / "src", "upper", "msg/Pair.msg", "msg/Other.msg", depends=["lower"]
    )
    write(upper / "msg/Pair.msg", "lower/Number first\nlower/Number[] others\n")

    built(root)

    modules = root / "install/upper/lib"
    assert [*modules.glob("*/site-packages/upper/msg/_other.py")]
    assert not [*(root / "install").glob("*/include/**/*.hpp")]  # only on request

    (upper / "msg/Other.msg").unlink()
    lists = upper / "CMakeLists.txt"
    write(lists, lists.read_text().replace('  "msg/Other.msg"\n', ""))

    assert built(root).summary == "2 packages: 1 built, 1 unchanged"
    assert not [*modules.glob("*/site-packages/upper/msg/_other*")]
    assert [*modules.glob("*/site-packages/upper/msg/_pair.py")]


@pytest.mark.thorough
def test_interfaces_for_cpp_on_request(tmp_path: Path):
    message_package(tmp_path / "src", "messages")
    built(tmp_path)

    assert built(tmp_path, "--cpp").summary == "1 package: 1 built, 0 unchanged"

    assert [*tmp_path.glob("install/messages/include/**/number.hpp")]
