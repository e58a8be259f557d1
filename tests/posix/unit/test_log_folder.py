"""Where logs go, also where nothing can be written to the folder that ROS names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.output.logs.run_directory import current_root, log_root, provide_log_root
from launcher.posix import log_folder
from launcher.posix.socket_directory import NAME

NOWHERE = "/proc/none"  # nobody can make anything there
PRIVATE = f"{NAME}-{os.getuid()}"


@pytest.mark.parametrize(
    ("env", "root"),
    [
        ({"ROS_LOG_DIR": "/a", "ROS_HOME": "/b", "HOME": "/c"}, "/a"),
        ({"ROS_LOG_DIR": "", "ROS_HOME": "/b", "HOME": "/c"}, "/b/log"),
        ({"HOME": "/c"}, "/c/.ros/log"),
        ({"ROS_LOG_DIR": "log"}, os.path.abspath("log")),
        ({"ROS_HOME": "."}, os.path.abspath("log")),
    ],
)
def test_the_logs_are_where_ros_has_them(env, root):
    assert log_root(env) == root


def provided(env: dict[str, str]) -> str:
    """What it warns of; empty if of nothing."""
    said: list[str] = []
    provide_log_root(env, said.append)
    assert len(said) < 2
    return "".join(said)


@pytest.mark.parametrize("exists", [True, False])
def test_a_folder_that_can_be_written_stays_as_it_is(tmp_path: Path, exists: bool):
    (tmp_path / ".ros" / "log").mkdir(parents=exists) if exists else None
    before = sorted(tmp_path.rglob("*"))
    env = {"HOME": str(tmp_path)}
    assert provided(env) == ""
    assert env == {"HOME": str(tmp_path)}
    assert current_root(env) == str(tmp_path / ".ros" / "log")
    assert sorted(tmp_path.rglob("*")) == before, "nothing is made before it is needed"


def test_rcl_needs_a_path_where_home_is_not_set(tmp_path: Path):
    env = {"ROS_HOME": str(tmp_path)}
    assert provided(env) == ""
    assert env["ROS_LOG_DIR"] == f"{tmp_path}/log"


@pytest.mark.parametrize(
    ("env", "why"),
    [
        ({"HOME": NOWHERE}, f"{NOWHERE}/.ros/log (No such file or directory)"),
        ({"HOME": "/", "ROS_LOG_DIR": f"{NOWHERE}/log"}, "No such file or directory"),
        ({"HOME": "/", "ROS_HOME": "/dev/null"}, "/dev/null/log (Not a directory)"),
        ({"HOME": "/", "ROS_LOG_DIR": "~nobody-of-this-name/log"}, "(there is no home folder)"),
    ],
)
def test_else_the_logs_are_in_a_private_folder(tmp_path: Path, env: dict[str, str], why: str):
    env["TMPDIR"] = str(tmp_path)
    folder = str(tmp_path / PRIVATE / "log")
    text = provided(env)
    assert text.startswith("cannot write to the log folder ") and why in text
    assert text.endswith(f": logs go to {folder}; ROS_LOG_DIR chooses another")
    assert env["ROS_LOG_DIR"] == folder
    assert (tmp_path / PRIVATE).stat().st_mode & 0o777 == 0o700
    assert current_root(env) == folder
    assert provided(env) == "", "children find a folder that can be written"


def test_verbs_find_the_runs_that_are_there(tmp_path: Path):
    env = {"HOME": NOWHERE, "XDG_STATE_HOME": str(tmp_path / "state")}
    provide_log_root(dict(env), lambda text: None)
    assert current_root(env) == str(tmp_path / "state" / PRIVATE / "log")


def test_a_folder_of_which_others_have_a_part_is_not_used(tmp_path: Path):
    """In /tmp anybody could have made it, or a link in its place."""
    theirs, linked, ours = (tmp_path / name for name in ("theirs", "linked", "ours"))
    (theirs / PRIVATE).mkdir(parents=True)
    (theirs / PRIVATE).chmod(0o755)
    (linked / "elsewhere").mkdir(parents=True, mode=0o700)
    (linked / PRIVATE).symlink_to("elsewhere")
    env = {"HOME": NOWHERE, "XDG_STATE_HOME": str(theirs), "TMPDIR": str(ours)}
    provide_log_root(env, lambda text: None)
    assert env["ROS_LOG_DIR"] == str(ours / PRIVATE / "log")
    env = {"HOME": NOWHERE, "XDG_STATE_HOME": str(linked), "TMPDIR": str(ours)}
    provide_log_root(env, lambda text: None)
    assert env["ROS_LOG_DIR"] == str(ours / PRIVATE / "log")
    assert list((linked / "elsewhere").iterdir()) == []


def test_where_there_is_no_folder_at_all_the_warning_says_what_follows(
    monkeypatch: pytest.MonkeyPatch,
):
    def others(env: object) -> Iterator[str]:
        yield f"{NOWHERE}/log"

    monkeypatch.setattr(log_folder, "_others", others)
    env = {"HOME": NOWHERE}
    text = provided(env)
    assert text.endswith(": no ROS node can start; set ROS_LOG_DIR to another")
    assert env == {"HOME": NOWHERE}
