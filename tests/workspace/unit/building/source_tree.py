"""Packages of a workspace as files, for tests."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from pathlib import Path

MINIMUM = "cmake_minimum_required(VERSION 3.8)\n"
HEAD = """\
<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>0.1.0</version>
  <description>A package of the tests</description>
  <maintainer email="someone@example.org">Someone</maintainer>
  <license>MIT</license>
"""


def manifest(name: str, *tags: str, build_type: str = "ament_cmake") -> str:
    """A package.xml; `tags` are those between head and export, the first one in line 8."""
    lines = "".join(f"  {tag}\n" for tag in tags)
    export = f"  <export><build_type>{build_type}</build_type></export>\n</package>\n"
    return HEAD.format(name=name) + lines + export


INTERFACE_TAGS = (
    "<buildtool_depend>ament_cmake</buildtool_depend>",
    "<buildtool_depend>rosidl_default_generators</buildtool_depend>",
    "<depend>std_msgs</depend>",
    "<exec_depend>rosidl_default_runtime</exec_depend>",
    "<member_of_group>rosidl_interface_packages</member_of_group>",
)


def interface_package(
    name: str, files: Mapping[str, str], *, cmake: str = "", tags: tuple[str, ...] = ()
) -> dict[str, str]:
    """The files of an interface package: `files` is path -> text of the interfaces."""
    listed = "".join(f'\n  "{file}"' for file in files)
    cmake = cmake or (
        "cmake_minimum_required(VERSION 3.8)\n"
        f"project({name})\n"
        "find_package(ament_cmake REQUIRED)\n"
        "find_package(rosidl_default_generators REQUIRED)\n"
        "find_package(std_msgs REQUIRED)\n"
        f"rosidl_generate_interfaces(${{PROJECT_NAME}}{listed}\n"
        "  DEPENDENCIES std_msgs)\n"
        "ament_export_dependencies(rosidl_default_runtime)\n"
        "ament_package()\n"
    )
    texts = {
        "package.xml": manifest(name, *INTERFACE_TAGS, *tags),
        "CMakeLists.txt": cmake,
        **files,
    }
    return {f"{name}/{file}": text for file, text in texts.items()}


def python_package(name: str, *tags: str, **texts: str | None) -> dict[str, str]:
    """The files of an ament_python package; `setup_py`, `setup_cfg`, ... replace one, or drop it.

    The resource marker is `marker`, the module `init`.
    """
    setup_py = f"""\
        from setuptools import find_packages, setup

        setup(
            name='{name}',
            version='0.1.0',
            packages=find_packages(exclude=['test']),
            data_files=[
                ('share/ament_index/resource_index/packages', ['resource/{name}']),
                ('share/{name}', ['package.xml']),
            ],
            install_requires=['setuptools'],
            entry_points={{'console_scripts': ['talker = {name}.talker:main']}},
        )
        """
    setup_cfg = f"""\
        [develop]
        script_dir=$base/lib/{name}
        [install]
        install_scripts=$base/lib/{name}
        """
    given: dict[str, tuple[str, str | None]] = {
        "manifest": ("package.xml", manifest(name, *tags, build_type="ament_python")),
        "setup_py": ("setup.py", textwrap.dedent(setup_py)),
        "setup_cfg": ("setup.cfg", textwrap.dedent(setup_cfg)),
        "marker": (f"resource/{name}", ""),
        "init": (f"{name}/__init__.py", ""),
        "talker": (f"{name}/talker.py", "def main():\n    print('talks')\n"),
    }
    for key, text in texts.items():
        given[key] = (given[key][0], text if text is None else textwrap.dedent(text))
    return {f"{name}/{file}": text for file, text in given.values() if text is not None}


def write(folder: Path, files: Mapping[str, str]) -> Path:
    """The files, with their folders, below `folder`."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder
