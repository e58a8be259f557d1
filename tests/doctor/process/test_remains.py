"""`doctor --uninstall-list`: each owner's folder is listed, with a command that removes it."""

from __future__ import annotations

import ast
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from launcher.cli.dispatch import main
from launcher.control.console.history_file import history_path
from launcher.control.console.prompt import open_history
from launcher.doctor import remains
from launcher.hosts.agent import takeover
from launcher.hosts.engine.systemd import unit_installer
from launcher.hosts.file.hosts_model import Host
from launcher.language.ros.generated_files import write_parameter_file
from launcher.launch.plan.shell_command import ParameterFileWriter
from launcher.output.logs.run_directory import EVENTS, new_run_path
from launcher.packages import overlay
from launcher.packages.source_packages import OVERLAY_FOLDER
from launcher.posix import log_folder, socket_directory
from launcher.posix.domain_lease import leased_domain
from launcher.posix.state_folder import state_folder
from launcher.run.byte_code_notice import FILE, is_new
from launcher.workspace.building.toolchain.compiler import zig_caches
from tests.support.json_forms import fit
from tests.support.repository import REPOSITORY


@pytest.fixture
def home(tmp_path: Path, monkeypatch) -> Path:
    """A machine on which nothing was done yet: home, temporary and run-time folder are empty."""
    for name in ("ROS_LOG_DIR", "ROS_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.delenv("ZIG_GLOBAL_CACHE_DIR", raising=False)
    for variable, name in (("HOME", "home"), ("TMPDIR", "tmp"), ("XDG_RUNTIME_DIR", "run")):
        (tmp_path / name).mkdir()
        monkeypatch.setenv(variable, str(tmp_path / name))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    return tmp_path / "home"


def listed(home: Path) -> dict[str, remains.Remain]:
    """Path below the folder of the test -> what is listed; what the machine has is left out."""
    top = f"{home.parent}/"
    found = [one for one in remains.remains(os.environ) if one.path.startswith(top)]
    return {one.path.removeprefix(top): one for one in found}


def test_nothing_is_listed_where_nothing_was_left(home: Path):
    assert listed(home) == {}


def leave_run(home: Path) -> None:
    run = Path(new_run_path(os.environ))
    run.mkdir(parents=True)
    (run / EVENTS).write_text("{}\n" * 5000)
    (run.parent / "latest").symlink_to(run)
    (run.parent / "python3_123_1795973480491.log").write_text("x")
    (run.parent / "smoke/2026-1").mkdir(parents=True)


def leave_units(home: Path) -> None:
    units, folders = map(Path, unit_installer.places(str(home)))
    (folders / "fleet").mkdir(parents=True)
    units.mkdir(parents=True)
    (folders / "fleet" / unit_installer.LIST).write_text("fleet.target\nrobot-1.service\n")
    for name in ("fleet.target", "robot-1.service"):
        (units / name).touch()


def leave_with_completion(home: Path) -> None:
    (home / ".bashrc").write_text("alias ll='ls -l'\nsource <(launcher completion bash)\n")
    script = home / ".config/fish/completions/launcher.fish"
    script.parent.mkdir(parents=True)
    script.write_text("function __launcher_completion\n")


LEFT = {
    "run": (leave_run, {"home/.ros/log", "home/.ros/log/latest", "home/.ros/log/smoke"}),
    "socket": (
        lambda _: socket_directory.prepare("7-x", os.environ, os.getuid()).touch(),
        {"run/ros-launcher"},
    ),
    "agent": (lambda _: takeover.socket_path("k").touch(), {f"tmp/ros-launcher-{os.getuid()}"}),
    "other logs": (
        lambda _: os.makedirs(log_folder.usable(os.environ, "/proc/none")[0]),
        {f"tmp/ros-launcher-{os.getuid()}"},
    ),
    "history": (
        lambda _: open_history(history_path(os.environ)),
        {"home/.local/state/ros-launcher"},
    ),
    "notices": (
        lambda _: is_new("a notice", f"{state_folder(os.environ)}/{FILE}"),
        {"home/.local/state/ros-launcher"},
    ),
    "package": (
        lambda home: overlay.of("a_package", str(home), {}),
        {f"tmp/launcher-packages-{os.getuid()}"},
    ),
    "plan": (lambda _: ParameterFileWriter()._own_folder(), {f"tmp/launcher-plan-{os.getuid()}"}),
    "parameters": (lambda _: write_parameter_file(None, "a", "a"), {"tmp/launch_params_"}),
    "compiler": (
        lambda _: os.makedirs(f"{zig_caches(os.environ)}1-2"),
        {"home/.cache/zig/launcher-1-2"},
    ),
    "sync": (lambda home: os.makedirs(home / Host.workspace), {f"home/{Host.workspace}"}),
    "units": (leave_units, {"home/.config/launcher/fleet"}),
    "completion": (
        leave_with_completion,
        {"home/.bashrc", "home/.config/fish/completions/launcher.fish"},
    ),
}


@pytest.mark.parametrize("kind", LEFT)
def test_what_an_owner_leaves_is_listed_and_its_command_removes_it(home: Path, kind: str):
    leave, expected = LEFT[kind]
    leave(home)

    found = listed(home)
    assert expected <= {re.sub("(launch_params_).*", r"\1", path) for path in found}
    remove(home, found.values())
    left = {"home/.bashrc"} if kind == "completion" else set()
    assert files(home.parent) == left


def remove(home: Path, found: Iterable[remains.Remain]) -> None:
    """Execute all commands, with a systemctl that does nothing."""
    programs = home.parent / "bin"
    programs.mkdir()
    (programs / "systemctl").symlink_to("/bin/true")
    env = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
    for one in found:
        subprocess.run(["sh", "-c", one.command], env=env, check=True)
    (programs / "systemctl").unlink()


def files(top: Path) -> set[str]:
    """All below a folder that is no folder itself."""
    return {
        os.path.relpath(os.path.join(folder, name), top)
        for folder, _, names in os.walk(top)
        for name in names
    }


def test_only_the_line_of_the_completion_is_removed(home: Path):
    leave_with_completion(home)
    remove(home, listed(home).values())

    assert (home / ".bashrc").read_text() == "alias ll='ls -l'\n"


def test_what_others_have_in_the_same_folders_is_not_listed(home: Path):
    leave_run(home)
    others = {
        "home/.ros/log/2026-11-29-15-11-01-132105-vm-638/launch.log",  # of ros2 launch
        "home/.cache/zig/o/a",
        "tmp/launcher-of-somebody",
        "tmp/ros-launcher-12345/x",
    }
    for path in others:
        (home.parent / path).parent.mkdir(parents=True, exist_ok=True)
        (home.parent / path).touch()
    remove(home, listed(home).values())

    assert files(home.parent) == others


def test_sizes_are_those_on_disk(home: Path):
    leave_run(home)
    (home / ".ros/log/smoke/2026-1/bag").write_bytes(bytes(range(256)) * 4096)
    found = listed(home)

    assert 2**20 <= found["home/.ros/log/smoke"].size_bytes < 2**21
    assert 15000 <= found["home/.ros/log"].size_bytes < 2**20


def test_it_is_printed_as_text_and_as_json_and_nothing_is_removed(home: Path, capsys):
    leave_run(home)
    before = files(home.parent)

    assert main(["doctor", "--uninstall-list"]) == 0
    text = capsys.readouterr().out
    assert main(["doctor", "--uninstall-list", "--json"]) == 0
    (answer,) = fit("doctor --uninstall-list", capsys.readouterr().out)
    entry = next(one for one in answer["remains"] if one["path"] == f"{home}/.ros/log/smoke")
    assert entry["command"] == f"rm -r {home}/.ros/log/smoke"
    assert f"  {entry['path']}: {entry['what']}\n{'':12}-> {entry['command']}\n" in text
    assert answer["size_bytes"] == sum(one["size_bytes"] for one in answer["remains"])
    assert files(home.parent) == before


def test_it_cannot_be_combined_with_a_repair(capsys):
    assert main(["doctor", "--fix", "--uninstall-list"]) == 2
    assert "exclude each other" in capsys.readouterr().err


# ---- is the list complete?


MAKERS = ("NamedTemporaryFile", "TemporaryDirectory", "mkdtemp", "mkstemp")


def calls_of_tempfile() -> Iterator[tuple[str, dict[str, ast.expr]]]:
    """(place, keywords) of every call in the launcher that makes a temporary file."""
    for path in sorted((REPOSITORY / "launcher").rglob("*.py")):
        if path.name == "setup.py":
            continue
        text = path.read_text(encoding="utf-8")
        if not any(name in text for name in MAKERS):  # parsing all takes two seconds
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func).rpartition(".")[2]
                if name in MAKERS:
                    keywords = {one.arg or "": one.value for one in node.keywords}
                    yield f"{path.relative_to(REPOSITORY)}:{node.lineno}", keywords


def test_every_temporary_file_has_a_name_that_is_listed():
    found = [(place, words) for place, words in calls_of_tempfile() if "dir" not in words]
    assert len(found) > 8
    for place, words in found:
        prefix = words.get("prefix")
        assert prefix is not None, f"{place}: a killed launcher would leave it without our name"
        text = ast.literal_eval(prefix) if isinstance(prefix, ast.Constant) else OVERLAY_FOLDER
        assert remains.TEMPORARY.fullmatch(f"{text}abcd_123"), place


LAUNCH_FILE = """\
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=["sh", "-c", "exit 1"]),
        Node(package="group_gp1", executable="monitor", parameters=[{"a": 1}]),
    ])
"""


@pytest.mark.thorough
def test_all_that_commands_leave_in_an_empty_home_is_listed(home: Path):
    work = home / "work"
    work.mkdir()
    (work / "some.launch.py").write_text(LAUNCH_FILE)
    (work / "some.expect.yaml").write_text(
        "for: 0.5 s\nexpect:\n  - {log: nobody, within: 0.5 s}\n"
    )
    env = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    lines = (
        "plan some.launch.py",
        "some.launch.py --required '*'",
        "smoke some.launch.py --expect some.expect.yaml",
        "topic list",
        "doctor",
        "run group_gp1 no_such_program",
        "bag info nothing",
    )
    with leased_domain() as domain:
        env["ROS_DOMAIN_ID"] = str(domain)
        for line in lines:
            words = [sys.executable, "-m", "launcher", *shlex.split(line)]
            subprocess.run(words, cwd=work, env=env, check=False, capture_output=True)
        # Ended with all that it could not remove.
        words = [sys.executable, "-m", "launcher", "some.launch.py"]
        killed = subprocess.Popen(words, cwd=work, env=env, stdout=subprocess.PIPE)
        assert killed.stdout is not None
        killed.stdout.readline()
        killed.kill()
        killed.communicate()  # until the watchdog has ended the others
    shutil.rmtree(work)

    assert {"home/.ros/log", "home/.ros/log/smoke", "run/ros-launcher"} <= listed(home).keys()
    remove(home, listed(home).values())
    assert files(home.parent) == set()
