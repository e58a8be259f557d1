"""Packages with the structure of well-known interface packages, with a few interfaces each.

The build files ask for the same packages and use the same CMake commands as the originals, whose
sources cannot be fetched by a test.
"""

from __future__ import annotations

from pathlib import Path

GENERATORS = ("ament_cmake", "rosidl_default_generators")

MANIFEST = """<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>1.2.3</version>
  <description>The structure of {name}.</description>
  <maintainer email="nobody@example.org">nobody</maintainer>
  <license>MIT</license>
{depends}
  <test_depend>ament_lint_auto</test_depend>
  <test_depend>ament_lint_common</test_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""

# In most of the originals.
HEAD = """cmake_minimum_required(VERSION 3.5)
project({name})

if(NOT CMAKE_CXX_STANDARD)
  set(CMAKE_CXX_STANDARD 17)
  set(CMAKE_CXX_STANDARD_REQUIRED ON)
endif()
if(CMAKE_COMPILER_IS_GNUCXX OR CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  add_compile_options(-Wall -Wextra -Wpedantic)
endif()
{found}
"""
TAIL = """
if(BUILD_TESTING)
  find_package(ament_lint_auto REQUIRED)
  ament_lint_auto_find_test_dependencies()
endif()

ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


class Package:
    """`cmake` is what is between HEAD and TAIL, or the whole file if it calls project()."""

    def __init__(
        self,
        name: str,
        depends: str,
        cmake: str,
        files: dict[str, str],
        *,
        manifest: str | None = None,
    ) -> None:
        self.name = name
        self.depends = depends.split()
        self.cmake = cmake
        self.files = files
        self.manifest = manifest

    def write(self, src: Path) -> None:
        tags = [
            *(f"  <buildtool_depend>{name}</buildtool_depend>" for name in GENERATORS),
            *(f"  <depend>{name}</depend>" for name in self.depends),
            "  <exec_depend>rosidl_default_runtime</exec_depend>",
        ]
        manifest = self.manifest or MANIFEST.format(name=self.name, depends="\n".join(tags))
        cmake = self.cmake
        if "project(" not in cmake:
            wanted = (*GENERATORS, *self.depends)
            found = "\n".join(f"find_package({name} REQUIRED)" for name in wanted)
            cmake = HEAD.format(name=self.name, found=found) + cmake + TAIL
        folder = src / self.name
        for file, text in {
            **self.files,
            "package.xml": manifest,
            "CMakeLists.txt": cmake,
        }.items():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_text(text)


TF2_MSGS = Package(
    "tf2_msgs",
    "action_msgs builtin_interfaces geometry_msgs",
    """
rosidl_generate_interfaces(${PROJECT_NAME}
  "action/LookupTransform.action" "msg/TFMessage.msg" "srv/FrameGraph.srv"
  DEPENDENCIES builtin_interfaces geometry_msgs
  ADD_LINTER_TESTS
)
install(FILES rule.yaml DESTINATION share/${PROJECT_NAME})
""",
    {
        "msg/TFMessage.msg": "geometry_msgs/TransformStamped[] transforms\n",
        "srv/FrameGraph.srv": "---\nstring frame_yaml\n",
        "action/LookupTransform.action": (
            "string target_frame\nbuiltin_interfaces/Duration timeout\n---\n"
            "geometry_msgs/TransformStamped transform\n---\n"
        ),
        "rule.yaml": "{}\n",
    },
)

# Lists in variables, actions first, headers that are installed.
CONTROL_MSGS = Package(
    "control_msgs",
    "action_msgs builtin_interfaces geometry_msgs sensor_msgs std_msgs trajectory_msgs",
    """
set(msg_files msg/JointTolerance.msg)
set(action_files action/FollowJointTrajectory.action)
rosidl_generate_interfaces(${PROJECT_NAME}
  ${action_files}
  ${msg_files}
  DEPENDENCIES action_msgs builtin_interfaces geometry_msgs sensor_msgs std_msgs trajectory_msgs
)
""",
    {
        "msg/JointTolerance.msg": "string name\nfloat64 position\n",
        "action/FollowJointTrajectory.action": (
            "trajectory_msgs/JointTrajectory trajectory\nJointTolerance[] path_tolerance\n"
            "builtin_interfaces/Duration goal_time_tolerance\n---\nint32 error_code\n"
            "int32 SUCCESSFUL=0\nint32 INVALID_GOAL=-1\nstring error_string\n---\n"
            "std_msgs/Header header\n"
        ),
    },
)
VISION_MSGS = Package(
    "vision_msgs",
    "std_msgs geometry_msgs",
    """
set(CMAKE_CXX_FLAGS "${CMAKE_CXX_FLAGS} -std=c++14 -Wall -Wextra -Wpedantic")
set(msg_files msg/Detection2D.msg)
rosidl_generate_interfaces(${PROJECT_NAME}
  ${msg_files}
  DEPENDENCIES std_msgs geometry_msgs
  ADD_LINTER_TESTS)
install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION include/${PROJECT_NAME})
ament_export_include_directories(include)
""",
    {
        "msg/Detection2D.msg": "std_msgs/Header header\ngeometry_msgs/Pose2D center\nstring id\n",
        "include/vision_msgs/create.hpp": "#pragma once\n",
    },
)
# A header-only library upon the C++ type support, in a separate folder.
GEOGRAPHIC_MSGS = Package(
    "geographic_msgs",
    "unique_identifier_msgs std_msgs geometry_msgs builtin_interfaces",
    """
rosidl_generate_interfaces(${PROJECT_NAME}
  "msg/GeoPoint.msg" "msg/MapFeature.msg" "srv/GetRoutePlan.srv"
  DEPENDENCIES unique_identifier_msgs geometry_msgs std_msgs builtin_interfaces
)
rosidl_get_typesupport_target(cpp_typesupport_target "${PROJECT_NAME}" rosidl_typesupport_cpp)
if(TARGET "${cpp_typesupport_target}")
  add_library(validation INTERFACE)
  add_subdirectory(include)
  target_link_libraries(validation INTERFACE ${cpp_typesupport_target})
  install(TARGETS validation EXPORT export_${PROJECT_NAME} LIBRARY DESTINATION lib)
  ament_export_targets(export_${PROJECT_NAME} HAS_LIBRARY_TARGET)
endif()
""",
    {
        "msg/GeoPoint.msg": "float64 latitude\nfloat64 longitude\nfloat64 altitude\n",
        "msg/MapFeature.msg": "unique_identifier_msgs/UUID id\n",
        "srv/GetRoutePlan.srv": "unique_identifier_msgs/UUID start\n---\nGeoPoint[] way\n",
        "include/CMakeLists.txt": (
            "target_include_directories(validation INTERFACE\n"
            "  $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}>\n"
            "  $<INSTALL_INTERFACE:include/${PROJECT_NAME}>)\n"
        ),
    },
)
# Without a language, with CMake code for other packages and a Python package.
NAV2_COMMON = Package(
    "nav2_common",
    "",
    """cmake_minimum_required(VERSION 3.5)
project(nav2_common NONE)
find_package(ament_cmake_core REQUIRED)
find_package(ament_cmake_python REQUIRED)
ament_python_install_package(nav2_common)
ament_package(CONFIG_EXTRAS "nav2_common-extras.cmake")
install(DIRECTORY cmake DESTINATION share/${PROJECT_NAME})
""",
    {
        "nav2_common/__init__.py": "",
        "nav2_common-extras.cmake": 'include("${nav2_common_DIR}/nav2_package.cmake")\n',
        "cmake/nav2_package.cmake": (
            "macro(nav2_package)\n  set(CMAKE_CXX_STANDARD 17)\nendmacro()\n"
        ),
    },
    manifest="""<?xml version="1.0"?>
<package format="3">
  <name>nav2_common</name>
  <version>1.3.0</version>
  <description>The structure of nav2_common.</description>
  <maintainer email="nobody@example.org">nobody</maintainer>
  <license>MIT</license>
  <depend>launch</depend>
  <depend>launch_ros</depend>
  <depend>osrf_pycommon</depend>
  <depend>rclpy</depend>
  <depend>python3-yaml</depend>
  <buildtool_depend>ament_cmake_core</buildtool_depend>
  <build_depend>ament_cmake_python</build_depend>
  <buildtool_export_depend>ament_cmake_core</buildtool_export_depend>
  <export><build_type>ament_cmake</build_type></export>
</package>
""",
)
# Needs three packages of the workspace; names rclcpp, which its CMakeLists.txt does not look for.
NAV2_MSGS = Package(
    "nav2_msgs",
    "",
    """cmake_minimum_required(VERSION 3.5)
project(nav2_msgs)
find_package(ament_cmake REQUIRED)
find_package(nav2_common REQUIRED)
find_package(builtin_interfaces REQUIRED)
find_package(nav_msgs REQUIRED)
find_package(geometry_msgs REQUIRED)
find_package(rosidl_default_generators REQUIRED)
find_package(std_msgs REQUIRED)
find_package(geographic_msgs)
find_package(action_msgs REQUIRED)
nav2_package()
add_compile_options(-Wno-error=deprecated)
rosidl_generate_interfaces(${PROJECT_NAME}
  "action/FollowGPSWaypoints.action"
  DEPENDENCIES builtin_interfaces geometry_msgs std_msgs action_msgs nav_msgs geographic_msgs
)
ament_export_dependencies(rosidl_default_runtime)
ament_package()
""",
    {
        "action/FollowGPSWaypoints.action": (
            "uint32 NONE=0\ngeographic_msgs/GeoPoint[] gps_poses\nnav_msgs/Path path\n---\n"
            "int16 error_code 0\n---\nuint32 current_waypoint\n"
        )
    },
    manifest=MANIFEST.format(
        name="nav2_msgs",
        depends="""  <buildtool_depend>ament_cmake</buildtool_depend>
  <build_depend>nav2_common</build_depend>
  <depend>rclcpp</depend>
  <depend>std_msgs</depend>
  <depend>builtin_interfaces</depend>
  <depend>rosidl_default_generators</depend>
  <depend>geometry_msgs</depend>
  <depend>action_msgs</depend>
  <depend>nav_msgs</depend>
  <depend>geographic_msgs</depend>""",
    ),
)
# The message files are found with GLOB, or copied from another folder of the repository.
GPS_MSGS = Package(
    "gps_msgs",
    "builtin_interfaces std_msgs",
    """
set(MSG_DEPS builtin_interfaces std_msgs)
file(GLOB found RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} msg/GPS*.msg)
list(SORT found)
rosidl_generate_interfaces(${PROJECT_NAME} ${found} DEPENDENCIES ${MSG_DEPS})
""",
    {"msg/GPSStatus.msg": "std_msgs/Header header\nint16 STATUS_NO_FIX=-1\nint16 status\n"},
)
FOXGLOVE_MSGS = Package(
    "foxglove_msgs",
    "builtin_interfaces geometry_msgs",
    """
file(GLOB schemas "${CMAKE_CURRENT_SOURCE_DIR}/schemas/*.msg")
file(REMOVE_RECURSE "${CMAKE_CURRENT_SOURCE_DIR}/msg")
file(COPY ${schemas} DESTINATION "${CMAKE_CURRENT_SOURCE_DIR}/msg")
file(GLOB msg_files RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}" "msg/*.msg")
rosidl_generate_interfaces(${PROJECT_NAME}
  ${msg_files}
  DEPENDENCIES builtin_interfaces geometry_msgs
  ADD_LINTER_TESTS
)
""",
    {"schemas/Color.msg": "float64 r\nfloat64 g\n", "schemas/Line.msg": "Color[] colors\n"},
)
# An empty DEPENDENCIES, the generators before ament_cmake.
CAN_MSGS = Package(
    "can_msgs",
    "",
    """cmake_minimum_required(VERSION 3.5)
project(can_msgs)
find_package(rosidl_default_generators REQUIRED)
find_package(ament_cmake REQUIRED)
find_package(std_msgs REQUIRED)
set(CMAKE_CXX_STANDARD 14)
rosidl_generate_interfaces(
    ${PROJECT_NAME}
        msg/Frame.msg
    DEPENDENCIES
)
ament_export_dependencies(rosidl_default_runtime)
ament_package()
""",
    {"msg/Frame.msg": "uint32 id\nbool is_rtr\nuint8 dlc\nuint8[8] data\n"},
    manifest=MANIFEST.format(
        name="can_msgs",
        depends="""  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  <depend>std_msgs</depend>
  <exec_depend>rosidl_default_runtime</exec_depend>""",
    ),
)
# For ROS 1 and 2: the dependencies have conditions on ROS_VERSION.
PX4_MSGS = Package(
    "px4_msgs",
    "builtin_interfaces",
    """
set(MSGS_DIR "${CMAKE_CURRENT_SOURCE_DIR}/msg")
file(GLOB PX4_MSGS RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}" "${MSGS_DIR}/*.msg")
rosidl_generate_interfaces(${PROJECT_NAME} ${PX4_MSGS}
  DEPENDENCIES builtin_interfaces
  ADD_LINTER_TESTS
)
""",
    {"msg/VehicleStatus.msg": "uint64 timestamp\nuint8 STATE_ARMED = 2\nuint8 state\n"},
    manifest=MANIFEST.format(
        name="px4_msgs",
        depends="""  <buildtool_depend condition="$ROS_VERSION == 1">catkin</buildtool_depend>
  <buildtool_depend condition="$ROS_VERSION == 2">ament_cmake</buildtool_depend>
  <build_depend condition="$ROS_VERSION == 1">message_generation</build_depend>
  <build_depend condition="$ROS_VERSION == 2">rosidl_default_generators</build_depend>
  <depend condition="$ROS_VERSION == 2">builtin_interfaces</depend>
  <exec_depend condition="$ROS_VERSION == 2">rosidl_default_runtime</exec_depend>""",
    ).replace("<build_type>", '<build_type condition="$ROS_VERSION == 2">'),
)
EXAMPLE_INTERFACES = Package(
    "example_interfaces",
    "action_msgs",
    """
rosidl_generate_interfaces(${PROJECT_NAME}
  "action/Fibonacci.action"
  "msg/WString.msg"
  "srv/AddTwoInts.srv"
)
install(FILES rules.yaml DESTINATION share/${PROJECT_NAME})
""",
    {
        "action/Fibonacci.action": "int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n",
        "msg/WString.msg": "wstring data\n",
        "srv/AddTwoInts.srv": "int64 a\nint64 b\n---\nint64 sum\n",
        "rules.yaml": "[]\n",
    },
)
OCTOMAP_MSGS = Package(
    "octomap_msgs",
    "std_msgs geometry_msgs",
    """
include_directories(include)
rosidl_generate_interfaces(${PROJECT_NAME} "msg/Octomap.msg" DEPENDENCIES std_msgs geometry_msgs)
install(DIRECTORY include/ DESTINATION include)
""",
    {
        "msg/Octomap.msg": "std_msgs/Header header\nbool binary\nstring id\nint8[] data\n",
        "include/octomap_msgs/conversions.h": "#pragma once\n",
    },
)
# Upon another package of the workspace.
MOVEIT_MSGS = Package(
    "moveit_msgs",
    "octomap_msgs action_msgs sensor_msgs geometry_msgs trajectory_msgs shape_msgs std_msgs",
    """
set(msg_files "msg/PlanningScene.msg")
set(action_files "action/MoveGroup.action")
rosidl_generate_interfaces(${PROJECT_NAME}
  ${msg_files}
  ${action_files}
  DEPENDENCIES
    action_msgs std_msgs geometry_msgs sensor_msgs shape_msgs trajectory_msgs octomap_msgs
  ADD_LINTER_TESTS
)
""",
    {
        "msg/PlanningScene.msg": "sensor_msgs/JointState state\noctomap_msgs/Octomap map\n",
        "action/MoveGroup.action": "PlanningScene scene\n---\nint32 code\n---\nstring state\n",
    },
)

PACKAGES = [value for value in list(globals().values()) if isinstance(value, Package)]
