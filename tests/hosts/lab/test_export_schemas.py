"""Exported manifests and Compose files agree with the schemas of Kubernetes and of Compose."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft7Validator

from launcher.export.unit_names import dns_label
from tests.support.exports import COMPOSE_SCHEMA, export, tool
from tests.support.hosts.requirements import program

ODD = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess, TimerAction
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=["echo", "$(X)", "${Y} 100%"], name="\\u00d6dd/one (1)"),
        ExecuteProcess(cmd=["true"], name="always", respawn=True, cwd="/tmp"),
        Node(package="group_gp1", executable="robot_1", name="n" * 80, emulate_tty=True,
             parameters=[{"text": "a\\nb", "number": 0.5}], additional_env={"API_KEY": "hush"}),
        TimerAction(period=1.25, actions=[Node(package="group_gp1", executable="robot_1",
                                               name="Late_One", namespace="/warehouse/a7")]),
    ])
"""
OPTIONS = (
    *("--restart", "always=on-failure,max=3", "--nice", "Late_One=5", "--cpus", "Late_One=0,1"),
    *("--limit", "Late_One:nofile=256,as=1G,core=0", "--stop", "always=term:1"),
)
HOSTS = """
hosts:
  bot.1: {address: 10.0.0.2, environment: {TOKEN: hush}}
  bot2: {address: 10.0.0.3, node_selector: {role: robot, zone: "7"}}
place: {always: bot.1, Late_One: bot2}
"""


@pytest.fixture(params=["fleet", "odd", "odd-shared"])
def words(request: pytest.FixtureRequest, tmp_path: Path) -> dict[str, Any]:
    """The launch file, and options of the export."""
    if request.param == "fleet":
        return {"words": ()}
    (tmp_path / "odd.launch.py").write_text(ODD)
    (tmp_path / "hosts.yaml").write_text(HOSTS)
    shared = ("--shared-memory",) if request.param == "odd-shared" else ()
    options = (*OPTIONS, "--hosts", str(tmp_path / "hosts.yaml"), *shared)
    return {"words": options, "target": tmp_path / "odd.launch.py"}


def exported(engine: str, folder: Path, words: dict[str, Any]) -> Path:
    options = dict(words)
    export(engine, folder, *options.pop("words"), **options)
    return folder


def validated(files: list[Path]) -> str:
    command = [tool("kubernetes-validate"), "--strict", *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    return f"{done.returncode}\n{done.stdout}{done.stderr}"


def test_kubernetes_accepts_the_manifests(words: dict[str, Any], tmp_path: Path):
    out = exported("kubernetes", tmp_path / "out", words)
    files = sorted((out / "manifests").iterdir())
    told = validated(files)
    assert told.startswith("0\n"), told
    assert told.count("passed for resource") >= len(files)
    listed = yaml.safe_load((out / "kustomization.yaml").read_text())["resources"]
    assert sorted(listed) == [f"manifests/{file.name}" for file in files]


def test_an_unknown_key_is_noticed(tmp_path: Path):
    out = exported("kubernetes", tmp_path / "out", {"words": ()})
    file = out / "manifests" / "robot-1.yaml"
    file.write_text(file.read_text().replace("hostNetwork:", "hostNetwrk:"))
    assert not validated([file]).startswith("0\n")


def test_the_compose_file_agrees_with_its_schema(words: dict[str, Any], tmp_path: Path):
    if not COMPOSE_SCHEMA.exists():
        pytest.skip(f"there is no {COMPOSE_SCHEMA}, which .ci/run downloads")
    schema = json.loads(COMPOSE_SCHEMA.read_text())
    schema["properties"]["name"] = {"type": "string", "pattern": "^[a-z0-9][a-z0-9_-]*$"}  # newer
    out = exported("compose", tmp_path / "out", words)
    document = yaml.safe_load((out / "compose.yaml").read_text())
    assert [error.message for error in Draft7Validator(schema).iter_errors(document)] == []


PROFILES = {
    "bot.1": {"always"},
    "bot2": {"late-one"},
    "local": {"dd-one-1", dns_label("n" * 80)},
}


def services(out: Path, *options: str) -> set[str]:
    """Those that podman-compose starts with these options."""
    if program("podman") is None:
        pytest.skip("not installed: podman")
    for host in ("bot.1", "local"):
        (out / f"{host}.env").write_text("TOKEN=x\nAPI_KEY=y\n")
    command = [tool("podman-compose"), *options, "config", "--services"]
    done = subprocess.run(command, cwd=out, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return {*done.stdout.split()}


def test_podman_compose_reads_the_compose_file(tmp_path: Path):
    out = exported("compose", tmp_path / "out", {"words": ()})
    assert services(out) == {"dispatcher", "monitor", "robot-1", "robot-2", "robot-3"}


@pytest.mark.parametrize("words", ["odd"], indirect=True)
def test_podman_compose_starts_on_each_host_only_its_own(words: dict[str, Any], tmp_path: Path):
    out = exported("compose", tmp_path / "out", words)
    assert {host: services(out, "--profile", host) for host in PROFILES} == PROFILES
    assert services(out) == set()
