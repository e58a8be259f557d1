"""The package rosbag2_interfaces as Jazzy and as Lyrical have it; types of one name differ.

Each type takes seconds to compile. So there are those that the tests use, and of Jazzy only those
that differ, with one that does not. The files of C++ are compiled together, without optimization.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

_CODES = "int32 return_code\nstring error_string\n"
_SUCCESS = "bool success\n"
_IS_PAUSED = {"srv/IsPaused": "---\nbool paused\n"}
_OF_ALL = {
    **_IS_PAUSED,
    "srv/Burst": "uint64 num_messages\n---\nuint64 actually_burst\n",
    "srv/GetRate": "---\nfloat64 rate\n",
    "srv/IsDiscoveryRunning": "---\nbool running\n",
    "srv/Pause": "---\n",
    "srv/Play": "builtin_interfaces/Time start_offset\n"
    "builtin_interfaces/Duration playback_duration\n"
    f"builtin_interfaces/Time playback_until_timestamp\n---\n{_SUCCESS}",
    "srv/PlayNext": f"---\n{_SUCCESS}",
    "srv/Seek": f"builtin_interfaces/Time time\n---\n{_SUCCESS}",
    "srv/SetRate": f"float64 rate\n---\n{_SUCCESS}",
    "srv/Snapshot": f"---\n{_SUCCESS}",
    "srv/StartDiscovery": f"---\n{_CODES}",
    "srv/StopDiscovery": f"---\n{_CODES}",
    "srv/TogglePaused": "---\n",
    "msg/WriteSplitEvent": "string closed_file\nstring opened_file\nstring node_name\n",
}


def _at(verb: str) -> str:
    return (
        f"builtin_interfaces/Time {verb}_time\nint32 {verb}_mode\nstring tracking_topic_name\n"
        f"---\n{_CODES}"
    )


TYPES: Mapping[str, Mapping[str, str]] = {
    "jazzy": {
        **_IS_PAUSED,
        "srv/Record": f"string uri\n---\n{_CODES}",
        "srv/Resume": "---\n",
        "srv/SplitBagfile": "---\n",
        "srv/Stop": "---\n",
    },
    "lyrical": {
        **_OF_ALL,
        "srv/Record": f"string uri\nbuiltin_interfaces/Time start_time\n---\n{_CODES}",
        "srv/Resume": _at("resume"),
        "srv/SplitBagfile": _at("split"),
        "srv/Stop": f"---\n{_CODES}",
        "msg/MessagesLostEvent": "string node_name\n"
        "MessagesLostEventTopicStat[] messages_lost_statistics\n",
        "msg/MessagesLostEventTopicStat": "string topic_name\nuint64 messages_lost_in_transport\n"
        "uint64 messages_lost_in_recorder\n",
    },
}
_PACKAGE = """\
<?xml version="1.0"?>
<package format="3">
  <name>rosbag2_interfaces</name>
  <version>0.0.1</version>
  <description>Services and messages of rosbag2</description>
  <maintainer email="group_gp1@example.com">group_gp1</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  <depend>builtin_interfaces</depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export><build_type>ament_cmake</build_type></export>
</package>
"""
_CMAKE = """\
cmake_minimum_required(VERSION 3.10)
project(rosbag2_interfaces)
set(CMAKE_C_FLAGS_RELEASE "-O0")
set(CMAKE_CXX_FLAGS_RELEASE "-O0")
find_package(ament_cmake REQUIRED)
find_package(builtin_interfaces REQUIRED)
find_package(rosidl_default_generators REQUIRED)
rosidl_generate_interfaces(${{PROJECT_NAME}}
  {files}
  DEPENDENCIES builtin_interfaces
)
foreach(support rosidl_typesupport_c rosidl_typesupport_fastrtps_c)
  set_target_properties(${{PROJECT_NAME}}__${{support}} PROPERTIES UNITY_BUILD ON)
endforeach()
ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


def write(packages: Path, distro: str) -> Path:
    """Make the sources in a folder of packages, which is returned."""
    folder = packages / "rosbag2_interfaces"
    files = []
    for name, text in TYPES[distro].items():
        path = folder / f"{name}.{name.partition('/')[0]}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        files.append(f'"{path.relative_to(folder)}"')
    (folder / "package.xml").write_text(_PACKAGE, encoding="utf-8")
    cmake = _CMAKE.format(files="\n  ".join(files))
    (folder / "CMakeLists.txt").write_text(cmake, encoding="utf-8")
    return packages
