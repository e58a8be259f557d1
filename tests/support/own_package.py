"""A package as `ros2 pkg create` makes it for Python, with a node and launch files."""

from __future__ import annotations

import textwrap
from pathlib import Path

MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>0.0.0</version>
  <description>a test</description>
  <maintainer email="a@b.example">a</maintainer>
  <license>MIT</license>
  {depends}
  <export><build_type>ament_python</build_type></export>
</package>
"""

SETUP = """\
import os
from glob import glob
from setuptools import find_packages, setup

package_name = {name!r}

setup(
    name=package_name,
    version="0.0.0",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
        (os.path.join("share", package_name, "launch"), glob({launch!r})),
        (os.path.join("share", package_name, "config"), glob({config!r})),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    entry_points={{"console_scripts": ["{name}_talker = {name}.talker:main"]}},
)
"""

SETUP_CFG = """\
[develop]
script_dir=$base/lib/{name}
[install]
install_scripts=$base/lib/{name}
"""

TALKER = """\
import os
import sys

from ament_index_python.packages import get_package_share_directory


def main():
    share = get_package_share_directory({name!r})
    print("node: there is p.yaml:", os.path.isfile(share + "/config/p.yaml"), sys.argv[1:])
"""

LAUNCH_FILE = """\
import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, LogInfo
from launch_ros.actions import Node
from launch_ros.substitutions import ExecutableInPackage, FindPackagePrefix, FindPackageShare

LOADED = get_package_share_directory({name!r})


def generate_launch_description():
    share = FindPackageShare({name!r})
    return LaunchDescription([
        DeclareLaunchArgument("who", default_value="nobody"),
        LogInfo(msg=f"loaded: {{os.path.isfile(LOADED + '/config/p.yaml')}}"),
        LogInfo(msg=["same: ", str(share.find({name!r}) == LOADED)]),
        LogInfo(msg=["prefix: ", FindPackagePrefix({name!r})]),
        ExecuteProcess(cmd=[ExecutableInPackage("{name}_talker", {name!r})], output="screen"),
        Node(
            package={name!r},
            executable="{name}_talker",
            parameters=[[share, "/config/p.yaml"]],
            output="screen",
        ),
    ])
"""

XML_FILE = """\
<launch>
  <node pkg="{name}" exec="{name}_talker" output="screen">
    <param from="$(find-pkg-share {name})/config/p.yaml"/>
  </node>
</launch>
"""


def write_package(parent: Path, name: str, *, moved: bool = False, depends: str = "") -> Path:
    """The source folder of a new package; `moved` if its files go elsewhere in share."""
    folder = parent / name
    launch, config = ("files/starts", "files") if moved else ("launch", "config")
    setup = SETUP.format(name=name, launch=f"{launch}/*.launch.*", config=f"{config}/*.yaml")
    texts = {
        "package.xml": MANIFEST.format(name=name, depends=depends),
        "setup.py": setup,
        "setup.cfg": SETUP_CFG.format(name=name),
        f"resource/{name}": "",
        f"{name}/__init__.py": "",
        f"{name}/talker.py": TALKER.format(name=name),
        f"{launch}/{name}.launch.py": LAUNCH_FILE.format(name=name),
        f"{launch}/{name}_xml.launch.xml": XML_FILE.format(name=name),
        f"{config}/p.yaml": "/**: {ros__parameters: {rate: 3}}\n",
    }
    for path, text in texts.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(textwrap.dedent(text), encoding="utf-8")
    return folder
