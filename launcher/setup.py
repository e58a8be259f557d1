"""The packages of the distribution ros2-launcher, of which this folder is the top one."""

import tempfile

from setuptools import find_packages, setup

BUILD = tempfile.TemporaryDirectory()  # else there would be a copy of all modules among them

setup(
    options={"build": {"build_base": BUILD.name}},
    packages=["launcher", *(f"launcher.{name}" for name in find_packages())],
    package_dir={"launcher": "."},
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
    zip_safe=False,
)
