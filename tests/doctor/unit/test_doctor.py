"""Findings of the doctor for given facts."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.base.model.level import Level
from launcher.base.model.record import replace
from launcher.cli import dispatch as cli
from launcher.doctor import verb as doctor
from launcher.doctor.checks import CHECKS, MB, check_all
from launcher.doctor.collect import MARKERS, obstacle, prefixes, space
from launcher.doctor.doctor_facts import (
    DoctorFacts,
    Finding,
    Leftover,
    Prefix,
    Space,
    Unreachable,
)
from launcher.packages.byte_code import Uncached
from launcher.posix import proc
from launcher.posix.cleanup.run_id import abandoned_runs, is_abandoned, run_id_of
from launcher.run.monitor.shared_memory import Stale

HEALTHY = DoctorFacts(
    stale=(),
    leftovers=(),
    stale_groups=(),
    unreachable=(),
    shared_memory=Space(total_bytes=8000 * MB, free_bytes=7000 * MB),
    ros="ROS 2 Jazzy, from wheels",
    ros_misfit=None,
    ros_conflict=None,
    ros_remedy="source the setup file, or pip install 'ros2-launcher[jazzy]'",
    has_wheels=True,
    import_errors={},
    prefixes=(Prefix("/venv", exists=True),),
    python_prefix="/venv",
    is_bootstrapped=True,
    library_path=("/venv/lib/python3/site-packages/ros_rcl.libs", "/venv/lib"),
    version="0.1.0",
    folder="/src/launcher",
    installed_version="0.1.0",
    domain_id=None,
    log_folder="/home/me/.ros/log",
    log_obstacle=None,
    open_files=1024,
    open_files_hard=4096,
)
NO_SO = {"rclpy": "librcl_action.so: cannot open shared object file"}
SEGMENT = Stale("fastrtps_0123456789abcdef", MB)
PORT = Stale("fastrtps_port7411", MB)
SHORT = Space(total_bytes=64 * MB, free_bytes=3 * MB)


def findings(**changes: object) -> list[Finding]:
    """Those that are not ok."""
    return [f for f in check_all(replace(HEALTHY, **changes)) if f.level is not Level.OK]


def test_a_healthy_machine_has_one_good_finding_per_check():
    assert [f.level for f in check_all(HEALTHY)] == [Level.OK] * len(CHECKS)


@pytest.mark.parametrize(
    ("changes", "level", "text", "advice"),
    [
        ({"stale": (SEGMENT, PORT)}, "problem", "1 segment and 1 port: 2.0 MiB", "doctor --fix"),
        ({"stale": (PORT,)}, "note", "0 segments and 1 port", "doctor --fix"),
        (
            {"unreachable": (Unreachable(7, "robot"), Unreachable(8, "monitor"))},
            "problem",
            "removed while they run: robot [7], monitor [8]",
            "restart them",
        ),
        (
            {"leftovers": (Leftover("1-a", 7, "robot"), Leftover("1-a", 8, "sh"))},
            "problem",
            "left over from 1 killed run: robot [7], sh [8]",
            "SIGINT, then SIGTERM, then SIGKILL",
        ),
        (
            {"stale_groups": ("/sys/fs/cgroup/launcher-1-a",)},
            "note",
            "killed runs have left /sys/fs/cgroup/launcher-1-a",
            "doctor --fix removes them",
        ),
        ({"shared_memory": None}, "note", "UDP only", "tmpfs"),
        ({"shared_memory": SHORT}, "problem", "3.0 of 64 MiB are free", "--shm-size"),
        (
            {"shared_memory": Space(total_bytes=64 * MB, free_bytes=60 * MB)},
            "note",
            "room for about 89 more nodes",
            "--shm-size",
        ),
        (
            {"import_errors": {"rclpy": "No module"}},
            "problem",
            "rclpy: No module",
            "source the setup file, or pip install 'ros2-launcher[jazzy]'",
        ),
        (
            {"uncached": Uncached(("rclpy",), ("/a",), True, "python -m compileall -qq /a")},
            "note",
            "compiles rclpy again at every start, since PYTHONDONTWRITEBYTECODE is set, which",
            "unset PYTHONDONTWRITEBYTECODE, or: python -m compileall -qq /a",
        ),
        (
            {"uncached": Uncached(("launcher", "rclpy"), ("/a",), False, "sudo python")},
            "note",
            "compiles launcher, rclpy again at every start, since it may not write",
            "sudo python",
        ),
        ({"ros": None}, "problem", "none is found", "source the setup file, or pip install"),
        ({"ros_misfit": "is for Python 3.10"}, "problem", "is for Python 3.10", "source the"),
        (
            {"import_errors": {"std_msgs.msg": "No module", "rich": "No module"}},
            "problem",
            "rich: No module; std_msgs.msg: No module",
            "pip install rich; source the setup file, or pip install",
        ),
        ({"import_errors": {"yaml": "No module"}}, "problem", "yaml: No", "pip install pyyaml"),
        (
            {"prefixes": (Prefix("/gone", exists=False),)},
            "problem",
            "/gone does not exist",
            "remove it",
        ),
        (
            {"prefixes": (Prefix("/opt/ros", exists=True, hides=("rclpy",)),)},
            "problem",
            "/opt/ros hides the wheels' rclpy",
            "no other ROS was sourced",
        ),
        ({"installed_version": "0.10.0"}, "problem", "0.10.0 is installed", "update this one"),
        ({"installed_version": "0.0.9"}, "note", "0.0.9 is installed", "install again"),
        ({"domain_id": "abc"}, "problem", "'abc' is not a domain id", "0 to 232"),
        ({"domain_id": "233"}, "problem", "'233' is not a domain id", "0 to 232"),
        ({"domain_id": "-1"}, "problem", "'-1' is not a domain id", "0 to 232"),
        ({"domain_id": "102"}, "note", "UDP ports of domain 102", "up to 101"),
        (
            {"log_obstacle": "read-only"},
            "problem",
            "cannot be written to: read-only",
            "ROS_LOG_DIR",
        ),
        (
            {"kept_runs": 37, "kept_bytes": 1024 * MB},
            "note",
            "/home/me/.ros/log has 37 older runs that failed or have a snapshot, 1024 MiB",
            "delete those that are not needed",
        ),
        (
            {"kept_runs": 1, "kept_bytes": 1024 * MB},
            "note",
            "/home/me/.ros/log has 1 older run that failed or has a snapshot, 1024 MiB",
            "delete those that are not needed",
        ),
        ({"open_files": 256}, "problem", "only 256", "ulimit -n 4096"),
        ({"open_files": 256, "open_files_hard": 256}, "problem", "only 256", "limits.conf"),
    ],
)
def test_problems_are_reported_with_the_repair(
    changes: dict[str, object], level: str, text: str, advice: str
):
    (finding,) = findings(**changes)
    assert finding.level.value == level
    assert text in finding.text
    assert advice in (finding.advice or "")


@pytest.mark.parametrize(
    "changes",
    [
        {"installed_version": None},
        {"domain_id": ""},
        {"domain_id": "101"},
        {"domain_id": "232"},
        {"is_bootstrapped": False, "library_path": ()},
    ],
)
def test_unusual_settings_are_no_problem(changes: dict[str, object]):
    assert findings(**changes) == []


@pytest.mark.parametrize(
    ("path", "state"), [((), "is gone"), (("/other/lib",), "names another environment")]
)
def test_libraries_that_cannot_be_found_are_explained(path: tuple[str, ...], state: str):
    wheels, libraries = findings(library_path=path, import_errors=NO_SO)
    assert "librcl_action.so" in wheels.text
    assert wheels.advice == f"see '{libraries.name}' below"
    assert state in libraries.text
    assert "env -u _ROS_WHEELS_BOOTSTRAP_COMPLETE -u LD_LIBRARY_PATH" in (libraries.advice or "")


# ---- looking


def make_prefix(folder: Path, *packages: str) -> str:
    (folder / MARKERS).mkdir(parents=True)
    for package in packages:
        (folder / MARKERS / package).touch()
    return str(folder)


def test_only_another_ros_in_front_of_the_wheels_hides_them(tmp_path: Path):
    wheels = make_prefix(tmp_path / "venv", "rclpy", "std_msgs", "group_gp1")
    ros = make_prefix(tmp_path / "ros", "rclpy", "turtlesim")
    workspace = make_prefix(tmp_path / "ws", "group_gp1")
    gone = str(tmp_path / "gone")
    found = prefixes(os.pathsep.join([workspace, gone, ros, "", wheels, ros]), wheels)
    assert [(p.path, p.exists, p.hides) for p in found] == [
        (workspace, True, ()),
        (gone, False, ()),
        (ros, True, ("rclpy",)),
        (wheels, True, ()),
        (ros, True, ()),
    ]


def test_a_folder_that_could_be_made_is_no_obstacle(tmp_path: Path):
    (tmp_path / "file").touch()
    assert obstacle(tmp_path / "a" / "b") is None
    assert obstacle(tmp_path / "file" / "b") == f"{tmp_path / 'file'} is not a folder"


def test_a_folder_in_which_nothing_can_be_made_is_an_obstacle():
    """Root has the permission to write there."""
    assert obstacle(Path("/proc/log")) == "/proc: No such file or directory"


def test_a_missing_folder_has_no_known_free_space(tmp_path: Path):
    assert space(tmp_path / "gone") is None
    found = space(tmp_path)
    assert found is not None and 0 < found.free_bytes <= found.total_bytes


# ---- leftovers


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A /proc of the test's own."""
    monkeypatch.setattr(proc, "ROOT", str(tmp_path))
    return tmp_path


def make_process(
    root: Path, pid: int, start: int, run_id: str = "", *, state: str = "S", ns: str = "pid:[1]"
) -> None:
    folder = root / str(pid)
    (folder / "ns").mkdir(parents=True)
    (folder / "ns" / "pid").symlink_to(ns)
    fields = ["0"] * 18 + [str(start), "0"]
    (folder / "stat").write_text(f"{pid} (a) b) c) {state} {' '.join(fields)}")
    (folder / "environ").write_text(f"X=1\0LAUNCHER_RUN_ID={run_id}\0" if run_id else "X=1\0")


def test_a_process_is_left_over_when_its_launcher_is_gone(root: Path):
    make_process(root, os.getpid(), 1)
    make_process(root, 50, 10)  # a launcher that lives
    make_process(root, 60, 10, state="Z")  # one that has just died
    make_process(root, 90, 99)  # somebody who got the number of a dead one
    for pid, run_id in ((51, "50-a"), (52, "40-b"), (53, "60-c"), (54, "90-d"), (55, "mine")):
        make_process(root, pid, 20, run_id)
    assert abandoned_runs() == {"40-b": [52], "60-c": [53], "90-d": [54]}


def test_a_process_in_another_pid_namespace_is_not_judged(root: Path):
    make_process(root, os.getpid(), 1)
    make_process(root, 51, 20, "7-a", ns="pid:[2]")
    assert run_id_of(51) == "7-a"
    assert not is_abandoned(51, "7-a")


def test_the_run_that_the_doctor_itself_is_part_of_is_left_alone(root: Path):
    make_process(root, os.getpid(), 30, "40-b")
    make_process(root, 52, 20, "40-b")
    assert abandoned_runs() == {}


# ---- the verb


def test_text_aligns_and_indents_advice():
    some = [
        Finding("wheels", Level.OK, "there"),
        Finding("log folder", Level.PROBLEM, "full", "empty it"),
    ]
    assert doctor.as_text(some, ["freed 1 MiB"]).splitlines() == [
        "fixed: freed 1 MiB",
        "ok       wheels      there",
        "problem  log folder  full",
        "                     -> empty it",
    ]


@pytest.mark.parametrize(
    ("changes", "well"), [({}, True), ({"stale": (PORT,)}, True), ({"stale": (SEGMENT,)}, False)]
)
def test_json_contains_the_overall_result(changes: dict[str, object], well: bool):
    report = doctor.as_document(check_all(replace(HEALTHY, **changes)), [])
    assert (report["well"], report["fixed"]) == (well, [])
    assert len(report["findings"]) == len(CHECKS)


def test_an_unknown_word_is_a_usage_error():
    with pytest.raises(UsageError, match="unknown option '--fixx'"):
        doctor.main(["--fixx"])


def test_help_names_its_exit_codes(capsys: pytest.CaptureFixture[str]):
    assert cli.main(["doctor", "--help"]) == 0
    assert "exit codes: 0" in capsys.readouterr().out


def test_without_ros_nothing_is_said_about_wheels():
    bare = replace(HEALTHY, ros=None, has_wheels=False, prefixes=(), import_errors=NO_SO)
    found = {one.name: one for one in check_all(bare)}

    assert found["wheels"].advice == "see 'ROS 2' above"
    assert found["library path"].text == "no wheels are in use, which would need it"
    assert found["AMENT_PREFIX_PATH"].text == "not set"
