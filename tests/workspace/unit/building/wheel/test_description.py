"""What the metadata of a wheel say, and what it requires."""

from __future__ import annotations

import os
from email import message_from_string

import pytest

from launcher.base.errors import LauncherError
from launcher.packages.source_packages import MARKERS
from launcher.packages.workspace import MARKER
from launcher.workspace.building import sources
from launcher.workspace.building.wheel import dist_info, requirements
from launcher.workspace.building.wheel.archive import WheelEntry
from launcher.workspace.building.wheel.contents import WheelContents
from launcher.workspace.building.wheel.requirements import (
    Installed,
    in_workspaces,
    merged,
    of_package,
)

MANIFEST = """\
<package format="3">
  <name>{name}</name><version>{version}</version>
  <description>
    Stations of robots.
    Größe in Metern
  </description>
  <maintainer email="a@example.org">Jörg Ä</maintainer>
  <license>MIT</license><license>Apache-2.0</license>
  <url type="repository">https://example.org/stations</url>
  <author>Zoë</author>
  {depends}
  <export><build_type>ament_cmake</build_type></export>
</package>
"""
INTERFACES = "<member_of_group>rosidl_interface_packages</member_of_group>"
ENVIRONMENT = Installed(
    packages={
        "std_msgs": ("ros-std-msgs", "5.3.6"),
        "rosidl_default_runtime": ("ros-rosidl-default-runtime", "1.6.0"),
        "other_msgs": ("other_msgs", "1.0.0"),
    },
    libraries={"librcutils.so": ("ros-rcutils", "6.7.4"), "libstd.so": ("ros-std-msgs", "5.3.6")},
)


@pytest.fixture
def package(tmp_path):
    def make(name, depends="", version="1.2.3"):
        folder = tmp_path / name
        folder.mkdir()
        text = MANIFEST.format(name=name, version=version, depends=depends)
        (folder / "package.xml").write_text(text)
        return sources.read(str(folder))

    return make


def needs(one, *others, libraries=None):
    workspace = {other.name: other for other in others}
    found = of_package(one, workspace, ENVIRONMENT, libraries)
    return list(found.words), list(found.unknown)


def test_packages_of_ros_and_of_the_workspace(package):
    one = package(
        "one",
        "<depend>std_msgs</depend><exec_depend>low</exec_depend><build_depend>cmake</build_depend>"
        "<test_depend>pytest</test_depend><exec_depend>other_msgs</exec_depend>",
    )
    low = package("low", version="0.4.0")
    assert needs(one, low) == (["low>=0.4.0", "other_msgs>=1.0.0", "ros-std-msgs~=5.3.6"], [])


def test_libraries_need_the_very_version(package):
    one = package("one", "<depend>other_msgs</depend><depend>low</depend>")
    low = package("low", version="0.4.0")
    words, _ = needs(one, low, libraries={"librcutils.so", "libstd.so", "libc.so.6"})
    assert words == [
        "low==0.4.0",
        "other_msgs==1.0.0",
        "ros-rcutils~=6.7.4",
        "ros-std-msgs~=5.3.6",
    ]


def test_messages_need_the_runtime_even_if_package_xml_forgets_it(package):
    assert needs(package("one", INTERFACES)) == (["ros-rosidl-default-runtime~=1.6.0"], [])


def test_names_that_are_no_packages_of_ros(package):
    one = package("one", "<exec_depend>python3-yaml</exec_depend><exec_depend>launch</exec_depend>")
    assert needs(one) == ([], ["python3-yaml"])


def test_conditions_of_package_xml(package):
    one = package("one", '<depend condition="$ROS_VERSION == 1">std_msgs</depend>')
    assert needs(one) == ([], [])


def test_requirements_of_setup_py_do_not_loosen_others():
    words = ["ros-rclpy~=7.1.6"]
    assert merged(words, ["ros_rclpy", "numpy>=1; python_version<'4'"]) == (
        "numpy>=1; python_version<'4'",
        "ros-rclpy~=7.1.6",
    )


def test_installed_knows_the_wheels_of_ros():
    found = requirements.installed()
    assert found.packages["std_msgs"][0] == "ros-std-msgs"
    assert found.libraries["librcutils.so"][0] == "ros-rcutils"
    assert found.libraries["libfastcdr.so.2"][0] == "ros-fastcdr"


def test_metadata(package):
    fields = dist_info.fields_of(package("stations"))
    legal = [WheelEntry("LICENSE", b"As you like.")]
    contents = WheelContents((), (), "3.11", "[console_scripts]\n")
    made = dist_info.entries(fields, contents, "cp311-cp311-linux_x86_64", ["a==1"], legal)
    texts = {entry.name.partition("/")[2]: entry.read().decode() for entry in made}
    metadata = message_from_string(texts["METADATA"])
    assert metadata["Name"] == "stations" and metadata["Version"] == "1.2.3"
    assert metadata["License"] == "MIT, Apache-2.0"
    assert metadata["License-File"] == "LICENSE" and texts["licenses/LICENSE"] == "As you like."
    assert metadata["Requires-Python"] == "==3.11.*" and metadata["Requires-Dist"] == "a==1"
    assert metadata["Project-URL"] == "repository, https://example.org/stations"
    assert "Summary: Stations of robots. Größe in Metern\n" in texts["METADATA"]
    assert "Maintainer-email: Jörg Ä <a@example.org>\nLicense" in texts["METADATA"]
    assert "Root-Is-Purelib: false\nTag: cp311-cp311-linux_x86_64\n" in texts["WHEEL"]
    assert texts["entry_points.txt"] == "[console_scripts]\n"


def test_a_wheel_without_libraries_is_pure(package):
    fields = dist_info.fields_of(package("stations"))
    made = dist_info.entries(fields, WheelContents((), ()), "py3-none-any", [], [])
    texts = {entry.name.partition("/")[2]: entry.read().decode() for entry in made}
    assert "Root-Is-Purelib: true\n" in texts["WHEEL"]
    assert "Requires-Python" not in texts["METADATA"] and "entry_points.txt" not in texts


def test_a_package_without_package_xml(tmp_path):
    (tmp_path / "CMakeLists.txt").write_text("project(bare)\n")
    package = sources.read(str(tmp_path))
    with pytest.raises(LauncherError, match=r"bare has no package\.xml"):
        dist_info.fields_of(package)


def test_packages_of_other_workspaces_are_found_by_their_prefix(tmp_path):
    for workspace, package in (("low", "a"), ("low", "b"), ("other", "c")):
        prefix = tmp_path / workspace / "install" / package
        (prefix / MARKERS).mkdir(parents=True)
        (prefix / MARKERS / package).touch()
        (prefix.parent / MARKER).touch()
    prefixes = [str(path) for path in tmp_path.glob("*/install/*") if path.is_dir()]

    found = in_workspaces(["a", "b", "c", "d"], {"AMENT_PREFIX_PATH": os.pathsep.join(prefixes)})

    assert found == {str(tmp_path / "low"): ["a", "b"], str(tmp_path / "other"): ["c"]}
    assert in_workspaces(["a"], {}) == {}
