"""Any words on the command line: an exit code, no traceback, and never a process.

`run` becomes another program and the ROS verbs join the network, so the first word is one of
those that deal with launch files, or no verb at all.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from launcher.base.errors import LauncherError
from launcher.cli.dispatch import VERBS, main
from tests.support.examples import examples

LAUNCH_FILE = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=["touch", "started"]),
        DeclareLaunchArgument("mode", default_value="a", choices=["a", "b"]),
        DeclareLaunchArgument("never_given"),
    ])
"""
STARTERS = {"subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.exec", "os.system"}
OPTIONS = [
    "--json",
    "--lenient",
    "--debug",
    "-d",
    "-h",
    "--help",
    "-s",
    "--show-args",
    "-p",
    "--print",
    "-n",
    "-a",
    "--launch-prefix",
    "--launch-prefix=x",
    "--launch-prefix-filter",
    "--evaluation-timeout",
    "--evaluation-timeout=5",
    "--evaluation-timeout=-1",
    "--evaluation-timeout=nan",
    "--timeout",
    "--timeout=x",
    "--restart",
    "--restart=a=always",
    "--required",
    "--no-log-files",
    "--version",
    "--bogus",
    "--json=1",
    "-",
    "--",
    "--=",
]
ARGUMENTS = [
    "mode:=a",
    "mode:=c",
    "mode:=",
    ":=a",
    ":=",
    "mode=a",
    "mode:a",
    "modd:=a",
    "a:=b:=c",
    "sigterm_timeout:=1",
    "emulate_tty:=true",
    "mode:=\udcff",
    "mode:=\x1b[2J",
]
TARGETS = ["a.launch.py", "./a.launch.py", "gone.launch.py", ".", "..", "/", "", "a", "rclpy"]
NO_VERB = [[verb] for verb in VERBS if verb not in ("launch", "plan", "args")]

words = st.one_of(
    st.sampled_from(OPTIONS),
    st.sampled_from(ARGUMENTS),
    st.sampled_from(TARGETS),
    st.text(max_size=30),
    st.builds("{}:={}".format, st.text(max_size=8), st.text(max_size=8)),
)
first_words = st.sampled_from([["plan"], ["args"], ["launch"], []])
anything = st.builds(
    lambda first, target, rest: [*first, *target, *rest],
    first_words,
    st.sampled_from([[], ["a.launch.py"]]),
    st.lists(words, max_size=6),
)
# These get past the reading of the words nearly always.
nearly_right = st.builds(
    lambda first, arguments, options: [*first, "a.launch.py", *arguments, *options],
    first_words,
    st.lists(
        st.one_of(
            st.sampled_from([word for word in ARGUMENTS if ":=" in word.strip(":=")]),
            st.builds("{}:={}".format, st.text(min_size=1), st.text(min_size=1)),
        ),
        max_size=4,
    ),
    st.lists(st.sampled_from(["--lenient", "--evaluation-timeout=9", "--debug"]), max_size=2),
)
lines = st.one_of(anything, nearly_right).filter(lambda line: line[:1] not in NO_VERB)


class Witness:
    """Sees every attempt of this Python to start a process, while it is asked to look.

    Except for the process that reads a setup.py, to find what a package would install.
    """

    def __init__(self) -> None:
        self.is_looking = False
        self.seen: list[str] = []
        sys.addaudithook(self._hear)

    def _hear(self, event: str, arguments: tuple[object, ...]) -> None:
        what = f"{event} {arguments!r}"
        if self.is_looking and event in STARTERS and "packages/setup_reader.py" not in what:
            self.seen.append(what)


@pytest.fixture(scope="module")
def witness(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Witness]:
    """A witness in a folder with one launch file that cannot be launched."""
    folder = tmp_path_factory.mktemp("fuzz")
    (folder / "a.launch.py").write_text(LAUNCH_FILE)
    before = Path.cwd(), dict(os.environ)
    os.chdir(folder)
    os.environ.update(ROS_LOG_DIR=str(folder / "log"), TMPDIR=str(folder))
    yield Witness()
    os.chdir(before[0])
    os.environ.clear()
    os.environ.update(before[1])


def called(line: list[str]) -> tuple[int | None, str]:
    """(exit code, what was said); no code if an error was raised for its traceback."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(line)
        except LauncherError:
            assert "--debug" in line or "-d" in line
            return None, err.getvalue()
    return code, err.getvalue()


@settings(
    max_examples=examples(400),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(line=lines)
def test_any_words_end_in_an_exit_code_without_a_traceback_or_a_process(
    witness: Witness, line: list[str]
):
    witness.is_looking = True
    try:
        code, said = called(line)
    finally:
        witness.is_looking = False
    assert code in (None, 0, 2), said
    assert "Traceback" not in said
    assert witness.seen == []
    assert not Path("started").exists()


def test_the_witness_sees_a_process(witness: Witness):
    import subprocess

    witness.is_looking = True
    subprocess.run(["true"], check=True)
    witness.is_looking = False
    assert len(witness.seen) == 1
    witness.seen.clear()
