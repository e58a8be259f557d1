"""`hosts sync` over ssh: a fleet is synchronized, and runs from what was brought."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.support.children import children_named
from tests.support.hosts import Host, Lab
from tests.support.sync_hosts import PLAIN_PYTHON, WORKSPACE, tiny_wheel
from tests.support.verbs import Answer
from tests.support.waiting import wait_until
from tests.support.workspaces import BuiltWorkspace

CURRENT = f"{WORKSPACE}/current"


@pytest.fixture(scope="module")
def hosts(lab: Lab) -> dict[str, Host]:
    return {name: lab.host(name) for name in ("bot1", "bot2", "bot3")}


@pytest.fixture
def bot(hosts: dict[str, Host]) -> Iterator[Host]:
    """A host to which nothing was brought."""
    host = hosts["bot1"]
    shutil.rmtree(host.home / ".local", ignore_errors=True)
    yield host


@pytest.fixture
def workspace(fleet_workspace: BuiltWorkspace, tmp_path: Path) -> Path:
    """A small workspace with one package of files, which tests may change."""
    install = tmp_path / "ws/install/maps"
    for path, text in {
        "share/ament_index/resource_index/packages/maps": "",
        "share/colcon-core/packages/maps": "",
        "share/maps/package.dsv": "prepend-non-duplicate;AMENT_PREFIX_PATH;\n",
        "share/maps/hall.yaml": "first",
    }.items():
        (install / path).parent.mkdir(parents=True, exist_ok=True)
        (install / path).write_text(text)
    (tmp_path / "ws/install/.colcon_install_layout").write_text("isolated\n")
    return tmp_path / "ws"


def hall(host: Host) -> Path:
    return host.home / CURRENT / "install/share/maps/hall.yaml"


class Command:
    """`launcher hosts sync` on the operator's computer."""

    def __init__(self, lab: Lab, folder: Path, settings: Mapping[Host, Mapping[str, Any]]) -> None:
        self._lab = lab
        self._folder = folder
        self.file = lab.hosts_file(folder / "hosts.yaml", settings, {})

    def words(self, workspace: Path, *words: object) -> list[str]:
        base = ["hosts", "sync", f"--hosts={self.file}", f"--workspace={workspace}"]
        return [sys.executable, "-m", "launcher", *base, *map(str, words)]

    def run(self, workspace: Path, *words: object) -> Answer:
        done = self._lab.operator.run(
            self.words(workspace, *words), check=False, cwd=self._folder, timeout=300
        )
        return Answer(out=done.stdout, err=done.stderr, code=done.returncode)

    def start(self, workspace: Path, *words: object) -> subprocess.Popen[str]:
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        return self._lab.operator.popen(self.words(workspace, *words), cwd=self._folder, **pipes)


@pytest.fixture
def command(lab: Lab, bot: Host, tmp_path: Path) -> Command:
    return Command(lab, tmp_path, {bot: {}})


def test_a_fleet_runs_from_what_was_brought(
    lab: Lab, hosts: dict[str, Host], fleet_workspace: BuiltWorkspace, tmp_path: Path
):
    """Own message types, which were compiled here, and nodes that are linked into install/."""
    command = Command(lab, tmp_path, {host: {} for host in hosts.values()})

    done = command.run(fleet_workspace.root)
    again = command.run(fleet_workspace.root)

    assert done.code == 0, done.err
    assert {line.partition(":")[0] for line in done.out.splitlines()} == {*hosts}
    assert again.out.count("unchanged, 000001-") == len(hosts), again.out
    network = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_DOMAIN_ID": "42"}
    run = [f"{CURRENT}/bin/python", "-m", "launcher", "run", "fleet_nodes"]
    arguments = ["--ros-args", "-p", "robot_ids:=[bot2]", "-r", "__node:=bot2"]
    nodes = [
        hosts["bot1"].popen([*run, "dispatcher", *arguments[:3]], env=network),
        hosts["bot2"].popen([*run, "robot", "--ros-args", "-r", "__node:=bot2"], env=network),
    ]
    topic = ("/fleet/status", "fleet_interfaces/msg/RobotStatus")
    watch = [f"{CURRENT}/bin/launcher", "topic", "echo", *topic, "--once", "--timeout", "60"]
    try:
        heard = hosts["bot3"].run(watch, env=network, timeout=90)
    finally:
        for node in nodes:
            node.terminate()
            node.wait(60)
    assert "robot_id: bot2" in heard.stdout


def test_the_launcher_that_was_brought_is_used_there(command: Command, bot: Host, workspace: Path):
    command.run(workspace)

    code = "import launcher; print(launcher.__file__)"
    found = bot.run([f"{CURRENT}/bin/python", "-c", code]).stdout.strip()
    listed = bot.run([f"{CURRENT}/bin/launcher", "run", "maps"], check=False)

    assert found.startswith(f"{bot.home}/{WORKSPACE}/releases/")
    assert "executables of maps: none" in listed.stderr


def test_only_a_changed_file_is_sent_and_rollback_brings_it_back(
    command: Command, bot: Host, workspace: Path
):
    command.run(workspace)
    (workspace / "install/maps/share/maps/hall.yaml").write_text("second")

    dry = command.run(workspace, "--dry-run").out
    done = command.run(workspace).out
    assert "  ~ install/share/maps/hall.yaml\n" in dry and "would send 1 file" in dry
    assert "1 of " in done
    assert hall(bot).read_text() == "second"

    back = command.run(workspace, "--rollback")

    assert "bot1: went back from 000002-" in back.out
    assert hall(bot).read_text() == "first"


def test_a_host_that_is_off_stops_no_other(
    lab: Lab, hosts: dict[str, Host], workspace: Path, tmp_path: Path
):
    impatient = {"ssh": {**lab.ssh_options(), "ConnectTimeout": 1}}
    settings = {host: impatient if host.name == "bot2" else {} for host in hosts.values()}
    command = Command(lab, tmp_path, settings)
    hosts["bot2"].link_down()
    try:
        done = command.run(workspace)
    finally:
        hosts["bot2"].link_up()

    assert done.code == 1
    assert "host 'bot2': " in done.err
    assert {line.partition(":")[0] for line in done.out.splitlines()} == {"bot1", "bot3"}


def test_an_unknown_host_is_an_error(command: Command, workspace: Path):
    done = command.run(workspace, "bot9")

    assert done.code == 2
    assert "error: unknown host 'bot9'\nhint: did you mean 'bot1'?" in done.err


def test_a_full_disk_leaves_the_old_release(command: Command, bot: Host, workspace: Path):
    command.run(workspace)
    (workspace / "install/maps/share/maps/big.bin").write_bytes(os.urandom(20_000_000))
    folder = bot.home / WORKSPACE
    bot.run(["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", folder / "incoming"])
    try:
        done = command.run(workspace)
    finally:
        bot.run(["umount", "--lazy", folder / "incoming"])

    assert done.code == 1
    assert "the disk is full there" in done.err
    assert hall(bot).read_text() == "first"
    assert command.run(workspace).code == 0
    assert (hall(bot).parent / "big.bin").stat().st_size == 20_000_000


def receivers(host: Host) -> list[int]:
    return [
        process.pid
        for process in host.processes()
        if any("stdin.buffer" in word for word in process.words) and "-I" in process.words
    ]


@contextlib.contextmanager
def started_slowly(command: Command, bot: Host, workspace: Path) -> Iterator[subprocess.Popen[str]]:
    """The command, while a large file is received, which takes six seconds more."""
    path = workspace / "install/maps/share/maps/big.bin"
    path.write_bytes(os.urandom(60_000_000))
    bot.slow_link(bytes_per_s=10_000_000)
    try:
        process = command.start(workspace)
        wait_until(
            lambda: received(bot) > 1_000_000 or process.poll() is not None, "it is received"
        )
        assert process.poll() is None, process.communicate()
        yield process
    finally:
        bot.normal_link()


def received(host: Host) -> int:
    """Bytes of the file that is being received."""
    sizes = [0]
    for path in (host.home / WORKSPACE / "incoming").glob(".*.partial"):
        with contextlib.suppress(FileNotFoundError):  # it has got its name meanwhile
            sizes.append(path.stat().st_size)
    return max(sizes)


@pytest.mark.parametrize(
    "victim",
    [
        "operator",
        *(pytest.param(name, marks=pytest.mark.thorough) for name in ("receiver", "ssh", "sshd")),
        pytest.param("power", marks=pytest.mark.thorough),
    ],
)
def test_whatever_is_killed_the_old_release_stays(
    lab: Lab, command: Command, bot: Host, workspace: Path, victim: str
):
    command.run(workspace)
    with started_slowly(command, bot, workspace) as process:
        if victim == "operator":
            os.kill(process.pid, signal.SIGKILL)
        elif victim == "receiver":
            os.kill(receivers(bot)[0], signal.SIGKILL)
        elif victim == "ssh":
            os.kill(_ssh(process.pid), signal.SIGKILL)
        elif victim == "sshd":
            bot.kill_sshd_sessions()
        else:
            bot.power_off()
            process.kill()
            bot.power_on()
        process.communicate(timeout=60)
    wait_until(lambda: not receivers(bot), "the receiver ends")

    assert hall(bot).read_text() == "first"
    assert process.returncode != 0
    assert command.run(workspace).code == 0
    assert (hall(bot).parent / "big.bin").stat().st_size == 60_000_000
    assert len(list((bot.home / WORKSPACE / "releases").glob("0*"))) == 2


def _ssh(pid: int) -> int:
    (found,) = children_named(pid, "ssh")
    return found


def test_ctrl_c_ends_it_and_the_receiver(command: Command, bot: Host, workspace: Path):
    with started_slowly(command, bot, workspace) as process:
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)

    assert process.returncode == 130
    assert "interrupted; not done: bot1 (a release is used only when it is complete: " in err
    wait_until(lambda: not receivers(bot), "the receiver ends")
    assert not (bot.home / CURRENT).exists()


def test_a_link_that_is_down_for_long_frees_the_lock(
    lab: Lab, bot: Host, workspace: Path, tmp_path: Path
):
    """The receiver gives up by itself: sshd would not notice."""
    impatient = {"ServerAliveInterval": 1, "ServerAliveCountMax": 6}
    options = {"ssh": {**lab.ssh_options(), **impatient}}
    command = Command(lab, tmp_path, {bot: options})
    command.run(workspace)
    with started_slowly(command, bot, workspace) as process:
        bot.link_down()
        try:
            _, err = process.communicate(timeout=120)
            assert process.returncode == 1
            assert "host 'bot1': the connection was lost" in err
            wait_until(lambda: not receivers(bot), "the receiver ends", 120)
        finally:
            bot.link_up()

    assert hall(bot).read_text() == "first"
    assert command.run(workspace).code == 0


def test_an_environment_is_made_without_a_network(
    lab: Lab, bot: Host, workspace: Path, tmp_path: Path
):
    tiny_wheel(tmp_path / "house", "tiny", "1.0")
    (tmp_path / "list.txt").write_text("tiny==1.0\n")
    command = Command(lab, tmp_path, {bot: {"python": PLAIN_PYTHON}})
    options = (f"--requirements={tmp_path}/list.txt", f"--wheelhouse={tmp_path}/house")

    done = command.run(workspace, *options)

    assert done.code == 0, done.err
    assert "environment made in" in done.out
    code = "import sys, tiny; print(tiny.VERSION, sys.prefix)"
    version, prefix = bot.run([f"{CURRENT}/bin/python", "-c", code]).stdout.split()
    assert version == "1.0"
    assert prefix.startswith(f"{bot.home}/{WORKSPACE}/venvs/")


def test_a_host_without_a_network_and_wheels_says_what_to_do(
    lab: Lab, bot: Host, workspace: Path, tmp_path: Path
):
    (tmp_path / "list.txt").write_text("launcher-has-no-such-package==1.0\n")
    command = Command(lab, tmp_path, {bot: {"python": PLAIN_PYTHON}})

    done = command.run(workspace, f"--requirements={tmp_path}/list.txt")

    assert done.code == 1
    assert "'bot1': pip reaches no index of packages from there\nhint: give --wheel" in done.err
    assert not (bot.home / CURRENT).exists()


def test_two_operators_take_turns(command: Command, bot: Host, workspace: Path):
    results: list[Answer] = []
    other = workspace.with_name("other")
    shutil.copytree(workspace, other)
    (other / "install/maps/share/maps/hall.yaml").write_text("other")
    threads = [
        threading.Thread(target=lambda where=where: results.append(command.run(where)))
        for where in (workspace, other)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert [answer.code for answer in results] == [0, 0]
    assert hall(bot).read_text() in ("first", "other")
    assert len(list((bot.home / WORKSPACE / "releases").glob("0*"))) == 2
