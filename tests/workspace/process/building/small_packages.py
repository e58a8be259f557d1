"""Packages as small as they can be, and a way to build them."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

TIMEOUT_S = 500.0
COMMAND = (sys.executable, "-m", "launcher", "build")

_MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>0.1.0</version>
  <description>A test.</description>
  <maintainer email="nobody@example.org">Nobody</maintainer>
  <license>MIT</license>
{tags}
  <export><build_type>{build_type}</build_type></export>
</package>
"""
_SETUP = """\
from setuptools import setup

setup(
    name="{name}",
    version="0.1.0",
    packages=["{name}"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/{name}"]),
        ("share/{name}", ["package.xml"]),
    ],
    entry_points={{"console_scripts": ["greet = {name}.greet:main"]}},
)
"""
_SETUP_CFG = """\
[develop]
script_dir=$base/lib/{name}
[install]
install_scripts=$base/lib/{name}
"""
_CMAKE = """\
cmake_minimum_required(VERSION 3.10)
project({name} {languages})
find_package(ament_cmake REQUIRED)
{lines}
ament_package()
"""


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def manifest(name: str, build_type: str, *tags: str) -> str:
    lines = "\n".join(f"  {tag}" for tag in tags)
    return _MANIFEST.format(name=name, build_type=build_type, tags=lines)


def python_package(src: Path, name: str, *depends: str) -> Path:
    """A package with the executable `greet`, which prints `hello`."""
    folder = src / name
    tags = [f"<exec_depend>{one}</exec_depend>" for one in depends]
    write(folder / "package.xml", manifest(name, "ament_python", *tags))
    write(folder / "setup.py", _SETUP.format(name=name))
    write(folder / "setup.cfg", _SETUP_CFG.format(name=name))
    write(folder / "resource" / name, "")
    write(folder / name / "__init__.py", "")
    write(folder / name / "greet.py", "def main():\n    print('hello')\n")
    return folder


def cmake_package(
    src: Path, name: str, *lines: str, depends: Sequence[str] = (), languages: str = "NONE"
) -> Path:
    """A package with these lines in its CMakeLists.txt, and a launch file that it may install.

    CMake tries the compilers of its languages, which takes longer than all else.
    """
    folder = src / name
    tags = ["<buildtool_depend>ament_cmake</buildtool_depend>"]
    tags += [f"<depend>{one}</depend>" for one in depends]
    write(folder / "package.xml", manifest(name, "ament_cmake", *tags))
    write(
        folder / "CMakeLists.txt",
        _CMAKE.format(name=name, languages=languages, lines="\n".join(lines)),
    )
    write(folder / "launch" / "demo.launch.xml", "<launch/>\n")
    return folder


def files_package(
    src: Path, name: str, depends: Sequence[str] = (), languages: str = "NONE"
) -> Path:
    """A package that installs its launch file."""
    return cmake_package(
        src,
        name,
        "install(DIRECTORY launch DESTINATION share/${PROJECT_NAME})",
        depends=depends,
        languages=languages,
    )


def message_package(src: Path, name: str, *interfaces: str, depends: Sequence[str] = ()) -> Path:
    """A package with interface files such as `msg/Number.msg`, each with one number."""
    files = interfaces or ("msg/Number.msg",)
    dependencies = f"DEPENDENCIES {' '.join(depends)}" if depends else ""
    folder = cmake_package(
        src,
        name,
        "find_package(rosidl_default_generators REQUIRED)",
        *(f"find_package({one} REQUIRED)" for one in depends),
        "rosidl_generate_interfaces(${PROJECT_NAME}",
        *(f'  "{one}"' for one in files),
        f"  {dependencies})",
        languages="C CXX",
    )
    tags = [
        "<buildtool_depend>ament_cmake</buildtool_depend>",
        "<buildtool_depend>rosidl_default_generators</buildtool_depend>",
        *(f"<depend>{one}</depend>" for one in depends),
        "<exec_depend>rosidl_default_runtime</exec_depend>",
        "<member_of_group>rosidl_interface_packages</member_of_group>",
    ]
    write(folder / "package.xml", manifest(name, "ament_cmake", *tags))
    for file in files:
        write(folder / file, "int32 number\n")
    return folder


@dataclass(frozen=True)
class Build:
    """A finished `launcher build`."""

    code: int
    out: str
    err: str

    @property
    def summary(self) -> str:
        return self.out.splitlines()[-1] if self.out else ""


def build(root: Path, *words: str, env: Mapping[str, str] | None = None) -> Build:
    done = subprocess.run(
        [*COMMAND, *words],
        cwd=root,
        env=dict(os.environ if env is None else env),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
    )
    return Build(done.returncode, done.stdout, done.stderr)


def built(root: Path, *words: str, env: Mapping[str, str] | None = None) -> Build:
    """The same, and it succeeds."""
    done = build(root, *words, env=env)
    assert done.code == 0, done
    return done
