from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from importlib.metadata import Distribution
from pathlib import Path
from typing import Any

import pytest
import yaml

from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import ProcessSpec
from launcher.export import image
from launcher.export.export_model import ExportedFiles, ExportedSystem
from launcher.export.exported_system import system_of
from launcher.hosts.file.hosts_model import Discovery, Host
from launcher.launch.plan.planner import make_plan

Export = Callable[..., ExportedSystem]
BOT = Host(
    name="bot1",
    address="10.0.0.2",
    user="robot",
    python=".venv/bin/python",
    setup=("/opt/ros/jazzy/setup.sh", "my ws/setup.sh"),
    environment={"FLEET_TOKEN": "hush"},
)

HEAD = """
from launch import LaunchDescription
from launch.actions import *
from launch.event_handlers import *
from launch_ros.actions import *
from launch_ros.descriptions import ComposableNode

def node(name, **more):
    return Node(package="group_gp1", executable="robot_1", name=name, **more)

def generate_launch_description():
    return LaunchDescription([{}])
"""


KNOWN: dict[tuple[str, ...], dict[str, Distribution]] = {}


@pytest.fixture(scope="module", autouse=True)
def _what_packages_need_is_read_once() -> Iterator[None]:
    """The metadata of all that ROS 2 needs takes a tenth of a second, in each export."""
    closure = image._closure

    def read(roots: Iterable[Distribution]) -> dict[str, Distribution]:
        those = [*roots]
        names = tuple(one.metadata["Name"] for one in those)
        if names not in KNOWN:
            KNOWN[names] = closure(those)
        return KNOWN[names]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(image, "_closure", read)
        yield


@pytest.fixture
def exported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Export:
    """Exports the actions of a launch file `demo.launch.py`."""
    monkeypatch.chdir(tmp_path)  # packages are looked for below the working directory

    def export(
        actions: str,
        host_of: Callable[[ProcessSpec], Host | None] = lambda spec: None,
        options: RunOptions = RunOptions(),  # noqa: B008  (frozen)
        before: str = "",
        prefix: str = "",
        discovery: Discovery | None = None,
    ) -> ExportedSystem:
        path = tmp_path / "demo.launch.py"
        path.write_text(before + HEAD.replace("{}", actions))
        plan = make_plan(str(path), [])
        assert plan.error is None, plan.error
        return system_of(
            plan,
            host_of=host_of,
            options=options,
            command="launcher export",
            prefix=prefix,
            discovery=discovery,
        )

    return export


def first_on_bot(spec: ProcessSpec) -> Host | None:
    return BOT if spec.ros and spec.ros.node_name == "a" else None


def manifests(output: ExportedFiles, name: str) -> list[dict[str, Any]]:
    return list(yaml.safe_load_all(output.files[f"manifests/{name}.yaml"]))
