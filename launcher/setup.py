"""The packages of the distribution ros2-launcher, of which this folder is the top one."""

import os
import re
import shutil
import tempfile
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py
from setuptools.command.editable_wheel import editable_wheel
from setuptools.command.sdist import sdist

BUILD = tempfile.TemporaryDirectory()  # else there would be a copy of all modules among them
DEMO = "demo_package"  # the ROS package that `launcher demo` runs, as a source folder
HERE = Path(__file__).resolve().parent
# The last entry of Python's path: `import launch` where no package of this name is installed.
PATH_FILE = "ros2-launcher.pth"
ON_PATH = "language/compat/on_path"


def copy_demo(folder):
    """Copy the package beside this folder in the repository, or that of an sdist, to `folder`.

    Nothing is copied where an old pip has moved this folder elsewhere, without the repository.
    """
    source = HERE / DEMO if (HERE / DEMO).is_dir() else HERE.parent
    if source == HERE.parent and HERE.name != "launcher":
        return
    manifest = source / "package.xml"
    if not manifest.is_file():
        return
    name = re.search("<name>(.*?)</name>", manifest.read_text(encoding="utf-8"))[1]
    no_junk = shutil.ignore_patterns("__pycache__", "*.py[co]")
    for part in (name, "launch", "resource"):
        shutil.copytree(source / part, f"{folder}/{part}", ignore=no_junk, dirs_exist_ok=True)
    for part in ("package.xml", "setup.py", "setup.cfg"):
        shutil.copy(source / part, folder)


class BuildWithDemo(build_py):
    def run(self):
        super().run()
        if not self.editable_mode:  # which has the package in the repository
            copy_demo(os.path.join(self.build_lib, "launcher", DEMO))
            Path(self.build_lib, PATH_FILE).write_text(f"launcher/{ON_PATH}\n", encoding="utf-8")


class EditableWithPath(editable_wheel):
    def _install_namespaces(self, installation_dir, pth_prefix):
        super()._install_namespaces(installation_dir, pth_prefix)
        Path(installation_dir, PATH_FILE).write_text(f"{HERE / ON_PATH}\n", encoding="utf-8")


class SdistWithDemo(sdist):
    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        copy_demo(os.path.join(base_dir, DEMO))


setup(
    cmdclass={
        "build_py": BuildWithDemo,
        "editable_wheel": EditableWithPath,
        "sdist": SdistWithDemo,
    },
    options={"build": {"build_base": BUILD.name}},
    scripts=["cli/script/launcher"],
    packages=["launcher", *(f"launcher.{name}" for name in find_packages())],
    package_dir={"launcher": "."},
    package_data={
        "launcher": ["py.typed"],
        "launcher.workspace.building.create": ["templates/*/*.in"],
        "launcher.workspace.building.toolchain": ["*.cmake", "modules/*.cmake"],
        "launcher.language.compat": ["on_path/*.py"],
        "launcher.launch.supervise": ["*.json"],
        "launcher.faults": ["*.json"],
        "launcher.hosts": ["*.json", "*.xml"],
        "launcher.faults.incident": ["*.css"],
        "launcher.smoke": ["*.json"],
        "launcher.ros.draw": ["*.html"],
        "launcher.ros.probe": ["*.xml"],
        "launcher.ros.topics": ["*.xml"],
        "launcher.web": ["page/*", "page/*/*"],
    },
    zip_safe=False,
)
