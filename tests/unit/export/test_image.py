"""The recipe of an image: what is pinned, and what comes as a wheel."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from launcher.export.image import build_commands, files, image_of
from launcher.packages.sources import MARKERS
from tests.support.node_process import REPOSITORY


def pinned_in(path: Path) -> set[str]:
    return {
        re.sub(r"[-_.]+", "-", line.partition("==")[0]).lower()
        for line in path.read_text().splitlines()
        if "==" in line
    }


def test_what_is_pinned_is_what_the_launcher_needs():
    image = image_of("x", ["group_gp1"], {})
    names = {line.partition("==")[0] for line in image.pinned}
    assert names == pinned_in(REPOSITORY / "requirements" / "run.txt")
    assert image.wheels == ("group-gp1",)
    assert image.missing == image.built == ()


def test_the_recipe(tmp_path: Path):
    image = image_of("localhost/fleet", ["group_gp1"], {})
    recipe = files(image)["image/Containerfile"]
    assert f"FROM python:{image.python}-slim\n" in recipe
    assert "STOPSIGNAL SIGINT\n" in recipe
    assert "USER 10001\n" in recipe
    assert "--no-deps /tmp/wheels/group_gp1-*.whl" in recipe
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
