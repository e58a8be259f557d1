"""The recipe of an image: what is pinned, and what comes as a wheel."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.base.model.record import replace
from launcher.export.export_model import ExportedSystem
from launcher.export.export_settings import ExportSettings, export
from launcher.export.image import build_commands, files, image_of
from launcher.export.verbs.export import ENGINES
from launcher.packages.source_packages import MARKERS
from tests.support.repository import pins


def pinned_in(path: Path) -> set[str]:
    return {
        re.sub(r"[-_.]+", "-", line.partition("==")[0]).lower()
        for line in path.read_text().splitlines()
        if "==" in line
    }


def test_what_is_pinned_is_what_the_launcher_needs():
    image = image_of("x", ["group_gp1"], {})
    names = {line.partition("==")[0] for line in image.pinned}
    extra = {"lz4", "mcap", "mcap-ros2-support", "zstandard"}  # `bag`, which make run installs
    assert names == pinned_in(pins()) - extra
    assert image.wheels == ("group-gp1", "ros2-launcher")
    assert image.missing == image.built == ()


def test_the_recipe(tmp_path: Path):
    image = image_of("localhost/fleet", ["group_gp1"], {})
    recipe = files(image)["image/Containerfile"]
    assert f"FROM python:{image.python}-slim\n" in recipe
    assert "STOPSIGNAL SIGINT\n" in recipe
    assert recipe.index(f"-m compileall -qq /usr/local/lib/python{image.python} ") < recipe.index(
        "USER 10001\n"
    )
    assert "--no-deps /tmp/wheels/group_gp1-*.whl /tmp/wheels/ros2_launcher-*.whl" in recipe
    assert files(image)["image/requirements.txt"] == "".join(f"{one}\n" for one in image.pinned)
    assert build_commands(image)[-1] == "podman build --tag localhost/fleet image"


def test_packages_of_a_wheel_need_no_wheel_of_ours():
    assert "ros-std-msgs" in {
        line.partition("==")[0] for line in image_of("x", ["std_msgs"], {}).pinned
    }


def test_a_package_of_a_workspace_becomes_a_wheel(tmp_path: Path):
    marker = tmp_path / MARKERS / "my_robot"
    marker.parent.mkdir(parents=True)
    marker.touch()
    image = image_of("x", ["my_robot"], {"AMENT_PREFIX_PATH": str(tmp_path)})
    assert image.built == ("my_robot",)
    assert "launcher wheel --output image/wheels my_robot" in build_commands(image)
    assert "/tmp/wheels/*.whl" in files(image)["image/Containerfile"]


@pytest.mark.parametrize("package", ["no_such_package"])
def test_what_is_not_known_is_missing(package: str):
    assert image_of("x", [package], {}).missing == (package,)


@pytest.mark.parametrize("engine", ENGINES)
def test_an_image_of_the_user_needs_no_recipe(exported: Callable[..., ExportedSystem], engine: str):
    system = exported("node('a')")
    (process,) = system.processes
    system = replace(system, processes=(replace(process, package="no_such_package"),))
    is_lacking = "package no_such_package"

    with_recipe = export(engine, system, ExportSettings())
    in_containers = engine != "systemd"
    assert ("image/Containerfile" in with_recipe.files) is in_containers
    assert (is_lacking in [gap.what for gap in with_recipe.gaps]) is in_containers

    own = export(engine, system, ExportSettings(image="own:1"))
    assert not [name for name in own.files if name.startswith("image/")]
    assert is_lacking not in [gap.what for gap in own.gaps]
    assert "podman build" not in own.files["README.md"]
    assert ("an image of your own" in own.files["README.md"]) is in_containers
