"""What `make` says before and while it makes the environment."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from tests.support.repository import REPOSITORY
from tests.support.terminal import Terminal

# What pip prints without a terminal: 23.2, then 26.3.
PIP = """\
#!/bin/sh
case "$*" in *--quiet) exit 0;; esac
cat <<'END'
Collecting mcap==1.6.0 (from -r requirements/run.txt (line 6))
  Downloading mcap-1.6.0-py3-none-any.whl (22 kB)
Requirement already satisfied: pip in /usr/lib
Using cached https://files.example/a1/ros_sensor_msgs-5.5.1-cp311-cp311-linux.whl (1.5 MB)
  Using cached lark_parser-0.12.0-py2.py3-none-any.whl
Downloading empy-3.3.4.tar.gz (62 kB)
Installing collected packages: mcap, empy
Successfully installed empy-3.3.4 mcap-1.6.0
END
exit 7
"""


@pytest.fixture
def pip(tmp_path: Path) -> list[str]:
    program = tmp_path / "pip"
    program.write_text(PIP)
    program.chmod(0o755)
    return [str(REPOSITORY / "tools/pip_install"), str(program)]


def test_pip_shows_one_line_on_a_terminal_and_keeps_its_exit_code(pip: list[str]):
    with Terminal(pip, env=os.environ) as terminal:
        code = terminal.exit_code()
    lines = [line.removeprefix("\x1b[K") for line in terminal.raw.split("\r")]

    assert code == 7
    assert list(filter(None, lines)) == [
        "  0 MB  mcap-1.6.0 (22 kB)",
        "  1 MB  ros_sensor_msgs-5.5.1 (1.5 MB)",
        "  1 MB  empy-3.3.4 (62 kB)",
        "  installing",
    ]


def test_a_line_is_shown_when_pip_prints_it_and_not_at_the_end(tmp_path: Path):
    program = tmp_path / "pip"
    program.write_text("#!/bin/sh\necho 'Downloading mcap-1.6.0-py3.whl (2.0 MB)'\nread answer\n")
    program.chmod(0o755)
    with Terminal(
        [str(REPOSITORY / "tools/pip_install"), str(program)], env=os.environ
    ) as terminal:
        terminal.wait_for("  2 MB  mcap-1.6.0 (2.0 MB)")
        terminal.type("\n")
        assert terminal.exit_code() == 0


def test_pip_is_quiet_without_a_terminal(pip: list[str]):
    done = subprocess.run(pip, capture_output=True, text=True, check=True)

    assert (done.stdout, done.stderr) == ("", "")


def make(environment: Path, goal: str, option: str = "-n") -> str:
    """What `make` would do, or prints, with another environment than that of the tests."""
    words = ["make", option, f"VENV={environment}", goal]
    env = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    done = subprocess.run(
        words, cwd=REPOSITORY, env=env, capture_output=True, text=True, check=True
    )
    return done.stdout + done.stderr


def test_the_first_make_run_says_what_it_costs_and_what_comes_then(tmp_path: Path):
    said = make(tmp_path / "env", "run")
    cost, then = said.index("MB to download"), said.index("Then the fleet starts; Ctrl-C stops it.")

    assert cost < then < said.index(" -m venv ") < said.index("launcher system")
    assert "Then the fleet" not in make(tmp_path / "env", "env")


def test_the_first_make_test_says_how_long_it_takes(tmp_path: Path):
    said = make(tmp_path / "env", "test")

    assert said.index("the tests (5 minutes)") < said.index(" -m venv ")
    assert said.index(" -m venv ") < said.index("Adding the tools") < said.index("requirements/dev")


def test_a_later_make_says_nothing(tmp_path: Path):
    for name in (".python", ".run"):
        (tmp_path / name).touch()

    assert make(tmp_path, "env", "-s") == ""


def test_another_distribution_has_an_environment_and_lists_for_itself():
    def says(distro: str) -> subprocess.CompletedProcess[str]:
        env = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
        words = ["make", "-n", "-B", "dev", f"DISTRO={distro}"]
        return subprocess.run(words, cwd=REPOSITORY, env=env, capture_output=True, text=True)

    kilted = says("kilted").stdout
    assert " -m venv .venv-kilted" in kilted
    assert "requirements/run-kilted.txt" in kilted
    assert "requirements/dev-kilted.txt" in kilted
    assert says("humble").returncode == 2
    assert "PyPI has wheels of jazzy and kilted" in says("humble").stderr
