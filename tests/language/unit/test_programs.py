"""Programs that are given to the launcher as launch files: refused, and not executed."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from launcher.cli.dispatch import main

RAN = "open('ran', 'w').close()\n"
TALKER = (
    f"import time\n\n{RAN}\n\ndef main():\n    pass\n\n\nif __name__ == '__main__':\n    main()\n"
)


@pytest.fixture
def said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """What `plan` of a file says on standard error, and its exit code."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))

    def plan(text: str, name: str = "talker.py") -> tuple[int, str]:
        Path(name).write_text(text)
        return main(["plan", name]), capfd.readouterr().err

    return plan


@pytest.mark.parametrize("verb", ["launch", "plan", "args", "smoke"])
def test_a_program_is_refused_with_how_to_run_it(said, verb: str, capfd):
    Path("talker.py").write_text(TALKER)
    code, errors = main([verb, "talker.py"]), capfd.readouterr().err
    assert code == ExitCode.USAGE
    assert not Path("ran").exists()
    assert (
        f"{Path.cwd()}/talker.py:3: talker.py does not define generate_launch_description(): it is "
        "a program, not a launch file\n"
    ) in errors
    assert errors.endswith(
        "hint: write Node(executable='./talker.py') into a launch file, or run it alone: "
        "python3 talker.py\n"
    )


@pytest.mark.parametrize(
    ("name", "text", "line", "alone"),
    [
        ("guard.py", "\n\nif __name__ == '__main__':\n    pass\n", 3, "python3 guard.py"),
        ("loop.py", f"'''A loop.'''\n{RAN}while True:\n    pass\n", 2, "python3 loop.py"),
        ("talker", f"#!/usr/bin/env python3\n{RAN}", 2, "python3 talker"),
        ("go.launch.py", TALKER, 3, "python3 go.launch.py"),
        ("my talker.py", TALKER, 3, "python3 'my talker.py'"),
        ("go.sh", "#!/bin/bash\nfor i in 1; do echo 1; done\n", 1, "./go.sh"),
    ],
)
def test_the_line_that_shows_a_program_is_named(said, name: str, text: str, line: int, alone: str):
    code, errors = said(text, name)
    assert code == ExitCode.USAGE
    assert not Path("ran").exists()
    assert f"/{name}:{line}: {name} does not define generate_launch_description(): it is" in errors
    assert f"write Node(executable='./{name}') into" in errors
    assert errors.endswith(f"or run it alone: {alone}\n")


def test_an_included_program_is_refused_as_well(said):
    Path("talker.py").write_text(TALKER)
    code, errors = said(
        "from launch import LaunchDescription\n"
        "from launch.actions import IncludeLaunchDescription\n\n\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([IncludeLaunchDescription('talker.py')])\n",
        "a.launch.py",
    )
    assert code == ExitCode.USAGE
    assert not Path("ran").exists()
    assert "it is a program, not a launch file" in errors


HELPER = "from launch import LaunchDescription as make\n"


@pytest.mark.parametrize(
    "binding",
    [
        "def generate_launch_description():\n    return make()\n",
        "generate_launch_description = make\n",
        "from start_helper import generate_launch_description\n",
        "from start_helper import make as generate_launch_description\n",
        "from start_helper import *\n",
        "globals()['generate_' + 'launch_description'] = make\n",
        "vars()['generate_' + 'launch_description'] = make\n",
        "exec('generate_' + 'launch_description = make')\n",
        "def __getattr__(name):\n    if name.startswith('gen'):\n        return make\n"
        "    raise AttributeError(name)\n",
        "import start_by_launch\n",
        "try:\n    generate_launch_description = make\nfinally:\n    pass\n",
        "for generate_launch_description in [make]:\n    pass\n",
        "\uff47enerate_launch_description = make\n",
    ],
)
def test_a_file_that_binds_the_name_in_any_way_is_executed(said, monkeypatch, binding: str):
    monkeypatch.syspath_prepend(str(Path.cwd()))
    Path("start_helper.py").write_text(f"{HELPER}generate_launch_description = make\n")
    Path("start_by_launch.py").write_text(
        "import sys\n\nfrom start_helper import make\n\n"
        "frame = sys._getframe()\n"
        "while frame.f_globals['__name__'] != 'python_launch_file':\n    frame = frame.f_back\n"
        "frame.f_globals['generate_launch_description'] = make\n"
    )
    head = "import importlib\nmake = importlib.import_module('start_helper').make\nprint('ran')\n"
    code, errors = said(f"{head}{binding}", "start.py")
    assert (code, errors) == (ExitCode.OK, "ran\n")


@pytest.mark.parametrize("text", ["", "def helper():\n    pass\n", "import launch\nprint(1)\n"])
def test_a_file_that_shows_no_program_has_the_message_of_ros_2(said, text: str):
    code, errors = said(text, "start.py")
    assert code == ExitCode.USAGE
    assert "does not contain the required function 'generate_launch_description()'" in errors
    assert "hint: define generate_launch_description() that returns a LaunchDescription" in errors
