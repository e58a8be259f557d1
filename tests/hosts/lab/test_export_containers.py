"""The fleet in containers, from exported files: `podman kube play`, and podman-compose."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.support.containers import Podman, needs_podman
from tests.support.exports import FLEET, export, tool, works
from tests.support.hosts import Lab
from tests.support.hosts.leftovers import STATE
from tests.support.waiting import wait_until

IMAGE = "localhost/system:latest"
VARIABLES = {"ROS_DOMAIN_ID": "0", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}


@pytest.fixture(scope="module")
def podman(lab: Lab, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Podman]:
    """On a host of the lab, with the image that an exported recipe builds."""
    needs_podman()
    podman = Podman(STATE / f"podman-{os.getpid()}", lab.host("pods").port.path)
    try:
        out = tmp_path_factory.mktemp("image") / "out"
        export("kubernetes", out)
        podman.build(out / "image", IMAGE)
        yield podman
    finally:
        podman.close()


def export_here(engine: str, folder: Path, *words: str, target: Path = FLEET) -> None:
    export(engine, folder, *words, target=target, env=VARIABLES)


def seen(lab: Lab, *words: str) -> str:
    """What a verb prints on the operator's computer, outside of the containers."""
    return str(lab.operator.launcher(*words, env=VARIABLES).stdout)


def is_working(lab: Lab) -> bool:
    return works(seen(lab, "topic", "echo", "/fleet/report", "--once", "--timeout", "8"))


def test_the_image_runs_as_a_user_and_is_stopped_by_sigint(podman: Podman):
    shown = podman.run("image", "inspect", "--format", "{{.Config.User}} {{.Config}}", IMAGE).stdout
    assert shown.startswith("10001 ")
    assert "SIGINT" in shown


def test_kube_play_runs_the_fleet(lab: Lab, podman: Podman, tmp_path: Path):
    export_here("kubernetes", tmp_path / "out")
    files = sorted((tmp_path / "out" / "manifests").iterdir())
    with ThreadPoolExecutor() as pool:
        list(pool.map(lambda file: podman.run("kube", "play", file), files))
    try:
        wait_until(lambda: is_working(lab), "all robots have finished tasks")
        echo = ("topic", "echo", "/fleet/status", "--once")
        wait_until(lambda: '"robot_id": "robot_' in seen(lab, *echo), "a status is heard")
        # it says so with the next assignment, and may have done a task of the backlog before
        wait_until(lambda: "Late joiner" in podman.logs("robot-3"), "robot_3 took the backlog")
    finally:
        with ThreadPoolExecutor() as pool:
            list(pool.map(lambda file: podman.run("kube", "down", file), files))
    assert podman.run("ps", "--all", "--quiet").stdout == ""


def test_kube_play_gives_a_node_its_parameters(lab: Lab, podman: Podman, tmp_path: Path):
    (tmp_path / "one.launch.py").write_text(PARAMETERS)
    words = ("--image", IMAGE)
    export_here("kubernetes", tmp_path / "out", *words, target=tmp_path / "one.launch.py")
    file = tmp_path / "out" / "manifests" / "fast.yaml"
    podman.run("kube", "play", file)
    try:
        get = ["param", "get", "/fast", "task_duration_s"]
        wait_until(lambda: "0.125" in seen(lab, *get), "the parameter is set")
    finally:
        podman.run("kube", "down", file)


def test_kube_play_passes_on_what_the_launch_file_says(podman: Podman, tmp_path: Path):
    file = exported_dollars("kubernetes", tmp_path) / "manifests" / "dollars.yaml"
    podman.run("kube", "play", file)
    try:
        told = ["100% a$b ${c} $(d) sub $(X)"]
        wait_until(lambda: podman.logs("dollars").splitlines() == told, "the words are printed")
    finally:
        podman.run("kube", "down", file)


def exported_dollars(engine: str, folder: Path) -> Path:
    """The export of a program that prints words and a variable with dollars."""
    (folder / "dollars.launch.py").write_text(DOLLARS)
    export_here(engine, folder / "out", "--image", IMAGE, target=folder / "dollars.launch.py")
    return folder / "out"


DOLLARS = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    script = "echo 100% \\"$VALUE\\" $(echo sub) \\"$1\\"; exec sleep 600"
    return LaunchDescription([
        ExecuteProcess(cmd=["sh", "-c", script, "sh", "$(X)"], name="dollars",
                       additional_env={"VALUE": "a$b ${c} $(d)"}),
    ])
"""

PARAMETERS = """
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(package="group_gp1", executable="robot_1", name="fast",
             parameters=[{"task_duration_s": 0.125}]),
    ])
"""


def test_the_probe_tells_whether_the_node_is_there(lab: Lab, podman: Podman, tmp_path: Path):
    export_here("kubernetes", tmp_path / "out")
    file = tmp_path / "out" / "manifests" / "robot-1.yaml"
    probe = ["python3", "-m", "launcher", "node", "info"]
    podman.run("kube", "play", file)
    try:
        (name,) = re.findall(r"robot-1-pod\S*-robot-1", podman.run("ps").stdout)
        wait_until(
            lambda: podman.run("exec", name, *probe, "/robot_1", check=False).returncode == 0,
            "the node is found",
        )
        assert podman.run("exec", name, *probe, "/robot_9", check=False).returncode == 1
    finally:
        podman.run("kube", "down", file)


def test_compose_runs_the_fleet(lab: Lab, podman: Podman, tmp_path: Path):
    compose = tool("podman-compose")
    export_here("compose", tmp_path / "out")

    command = [compose, "--podman-path", str(podman.command)]
    options = {"cwd": tmp_path / "out", "env": podman.env, "check": True, "timeout": 120}
    subprocess.run([*command, "up", "--detach"], capture_output=True, **options)
    try:
        wait_until(lambda: is_working(lab), "all robots have finished tasks")
    finally:
        subprocess.run([*command, "down"], capture_output=True, **options)
    assert podman.run("ps", "--all", "--quiet").stdout == ""


def test_compose_starts_only_the_services_of_a_profile(lab: Lab, podman: Podman, tmp_path: Path):
    compose = tool("podman-compose")
    (tmp_path / "hosts.yaml").write_text(
        "hosts: {bot1: {address: 10.0.0.2}, bot2: {address: 10.0.0.3}}\n"
        "place: {robot_1: bot1, robot_2: bot2}\n"
    )
    export_here("compose", tmp_path / "out", "--hosts", str(tmp_path / "hosts.yaml"))
    command = [compose, "--podman-path", str(podman.command), "--profile", "bot1"]
    options = {"cwd": tmp_path / "out", "env": podman.env, "check": True, "timeout": 120}
    subprocess.run([*command, "up", "--detach"], capture_output=True, **options)
    try:
        names = podman.run("ps", "--format", "{{.Names}}").stdout.split()
        assert [name for name in names if "infra" not in name] == ["system_robot-1_1"]
    finally:
        subprocess.run([*command, "down"], capture_output=True, **options)
