"""Where well-known packages come from: the launcher, a wheel, sources, or an installation of ROS 2.

Repositories and branches are those of the lists of packages of the distributions (rosdistro).
"""

from __future__ import annotations

import re

from launcher.base.program import program
from launcher.packages.distribution import or_default

# Without a wheel, to be built from source: repository on GitHub, branch, and the package's folders
# where it is not the whole repository, "." for the one of its name. The branch DISTRO is
# called like the distribution.
SOURCES = {
    "ackermann_msgs": "ros-drivers/ackermann_msgs ros2",
    "action_tutorials_interfaces": "ros2/demos DISTRO action_tutorials/action_tutorials_interfaces",
    "actuator_msgs": "rudislabs/actuator_msgs main",
    "ament_cmake_auto": "ament/ament_cmake DISTRO .",
    "angles": "ros/angles ros2 .",
    "apriltag_msgs": "christianrauch/apriltag_msgs master",
    "autoware_common_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_control_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_localization_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_map_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_perception_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_planning_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_sensing_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_simulation_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_system_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_v2x_msgs": "autowarefoundation/autoware_msgs main .",
    "autoware_vehicle_msgs": "autowarefoundation/autoware_msgs main .",
    "can_msgs": "ros-industrial/ros_canopen dashing-devel .",
    "composition_interfaces": "ros2/rcl_interfaces DISTRO .",
    "control_msgs": "ros-controls/control_msgs DISTRO .",
    "controller_manager_msgs": "ros-controls/ros2_control DISTRO .",
    "dwb_msgs": "ros-navigation/navigation2 DISTRO nav2_dwb_controller/dwb_msgs",
    "example_interfaces": "ros2/example_interfaces DISTRO",
    "four_wheel_steering_msgs": "ros-drivers/four_wheel_steering_msgs ros2",
    "foxglove_msgs": "foxglove/foxglove-sdk main ros/src/foxglove_msgs schemas/ros2",
    "geographic_msgs": "ros-geographic-info/geographic_info ros2 .",
    "gps_msgs": "swri-robotics/gps_umd ros2-devel .",
    "grid_map_msgs": "ANYbotics/grid_map DISTRO .",
    "irobot_create_msgs": "iRobotEducation/irobot_create_msgs rolling",
    "map_msgs": "ros-planning/navigation_msgs DISTRO .",
    "marti_can_msgs": "swri-robotics/marti_messages ros2-devel .",
    "marti_common_msgs": "swri-robotics/marti_messages ros2-devel .",
    "marti_dbw_msgs": "swri-robotics/marti_messages ros2-devel .",
    "marti_introspection_msgs": "swri-robotics/marti_messages ros2-devel .",
    "marti_nav_msgs": "swri-robotics/marti_messages ros2-devel .",
    "marti_perception_msgs": "swri-robotics/marti_messages ros2-devel .",
    "marti_sensor_msgs": "swri-robotics/marti_messages ros2-devel .",
    "marti_status_msgs": "swri-robotics/marti_messages ros2-devel .",
    "marti_visualization_msgs": "swri-robotics/marti_messages ros2-devel .",
    "mavros_msgs": "mavlink/mavros ros2 .",
    "micro_ros_msgs": "micro-ROS/micro_ros_msgs rolling",
    "moveit_msgs": "moveit/moveit_msgs ros2",
    "nav2_common": "ros-navigation/navigation2 DISTRO .",
    "nav2_msgs": "ros-navigation/navigation2 DISTRO .",
    "nav_2d_msgs": "ros-navigation/navigation2 DISTRO nav2_dwb_controller/nav_2d_msgs",
    "nmea_msgs": "ros-drivers/nmea_msgs ros2",
    "object_recognition_msgs": "wg-perception/object_recognition_msgs ros2",
    "octomap_msgs": "OctoMap/octomap_msgs ros2",
    "pcl_msgs": "ros-perception/pcl_msgs ros2",
    "pendulum_msgs": "ros2/demos DISTRO .",
    "plotjuggler_msgs": "facontidavide/plotjuggler_msgs ros2",
    "px4_msgs": "PX4/px4_msgs main",
    "realsense2_camera_msgs": "IntelRealSense/realsense-ros ros2-master .",
    "rmf_charger_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_dispenser_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_door_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_fleet_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_ingestor_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_lift_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_obstacle_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_scheduler_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_site_map_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_task_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_traffic_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "rmf_workcell_msgs": "open-rmf/rmf_internal_msgs DISTRO .",
    "ros_environment": "ros/ros_environment DISTRO",
    "ros_gz_interfaces": "gazebosim/ros_gz DISTRO .",
    "rosapi_msgs": "RobotWebTools/rosbridge_suite DISTRO .",
    "rosbag2_interfaces": "ros2/rosbag2 DISTRO .",
    "rosbridge_msgs": "RobotWebTools/rosbridge_suite DISTRO .",
    "rtcm_msgs": "tilk/rtcm_msgs master",
    "sensor_msgs_py": "ros2/common_interfaces DISTRO .",
    "simulation_interfaces": "ros-simulation/simulation_interfaces main",
    "statistics_msgs": "ros2/rcl_interfaces DISTRO .",
    "tf2_msgs": "ros2/geometry2 DISTRO .",
    "topic_tools_interfaces": "ros-tooling/topic_tools DISTRO .",
    "turtlebot3_msgs": "ROBOTIS-GIT/turtlebot3_msgs DISTRO",
    "turtlebot4_msgs": "turtlebot/turtlebot4 DISTRO .",
    "twist_mux_msgs": "ros-teleop/twist_mux_msgs master",
    "ublox_msgs": "KumarRobotics/ublox ros2 . ublox_serialization",
    "ur_dashboard_msgs": "UniversalRobots/Universal_Robots_ROS2_Driver DISTRO .",
    "ur_msgs": "ros-industrial/ur_msgs humble-devel",
    "velodyne_msgs": "ros-drivers/velodyne ros2 .",
    "vision_msgs": "ros-perception/vision_msgs ros2 .",
    "webots_ros2_msgs": "cyberbotics/webots_ros2 master .",
    "xacro": "ros/xacro ros2",
}
# Repositories without a branch of that name.
_OTHER_BRANCHES = {
    "kilted": {
        "ROBOTIS-GIT/turtlebot3_msgs": "main",
        "ros-controls/control_msgs": "master",
        "turtlebot/turtlebot4": "jazzy",
    },
    "lyrical": {
        "ANYbotics/grid_map": "rolling",
        "ROBOTIS-GIT/turtlebot3_msgs": "main",
        "RobotWebTools/rosbridge_suite": "ros2",
        "UniversalRobots/Universal_Robots_ROS2_Driver": "main",
        "open-rmf/rmf_internal_msgs": "main",
        "ros-controls/control_msgs": "master",
        "ros-controls/ros2_control": "master",
        "ros-planning/navigation_msgs": "rolling",
        "turtlebot/turtlebot4": "jazzy",
    },
}
# With a wheel, which is called ros-DISTRO-NAME: those of all distributions with wheels.
_NAMES = """
action_msgs actionlib_msgs ament_cmake ament_cmake_core ament_cmake_cppcheck
ament_cmake_cpplint ament_cmake_export_definitions ament_cmake_export_dependencies
ament_cmake_export_include_directories ament_cmake_export_interfaces
ament_cmake_export_libraries ament_cmake_export_link_flags ament_cmake_export_targets
ament_cmake_flake8 ament_cmake_gen_version_h ament_cmake_gmock ament_cmake_gtest
ament_cmake_include_directories ament_cmake_libraries ament_cmake_pep257 ament_cmake_pytest
ament_cmake_python ament_cmake_ros ament_cmake_target_dependencies ament_cmake_test
ament_cmake_uncrustify ament_cmake_vendor_package ament_cmake_version ament_cppcheck
ament_cpplint ament_flake8 ament_index_cpp ament_index_python ament_lint ament_package
ament_pep257 ament_uncrustify builtin_interfaces common_interfaces diagnostic_msgs
fastcdr foonathan_memory_vendor
geometry_msgs gmock_vendor gtest_vendor libyaml_vendor lifecycle_msgs nav_msgs pybind11_vendor
rcl rcl_action rcl_interfaces rcl_lifecycle rcl_logging_interface
rcl_logging_spdlog rcl_yaml_param_parser rclpy rcpputils rcutils rmw rmw_dds_common
rmw_fastrtps_cpp rmw_fastrtps_shared_cpp rmw_implementation rmw_implementation_cmake
rosgraph_msgs rosidl_adapter rosidl_cli rosidl_cmake rosidl_core_generators
rosidl_core_runtime rosidl_default_generators rosidl_default_runtime
rosidl_dynamic_typesupport rosidl_dynamic_typesupport_fastrtps rosidl_generator_c
rosidl_generator_cpp rosidl_generator_py rosidl_generator_type_description rosidl_parser
rosidl_pycommon rosidl_runtime_c rosidl_runtime_cpp rosidl_typesupport_c
rosidl_typesupport_cpp rosidl_typesupport_fastrtps_c rosidl_typesupport_fastrtps_cpp
rosidl_typesupport_interface rosidl_typesupport_introspection_c
rosidl_typesupport_introspection_cpp rpyutils sensor_msgs service_msgs shape_msgs
spdlog_vendor std_msgs std_srvs stereo_msgs test_interface_files test_msgs tracetools
trajectory_msgs type_description_interfaces uncrustify_vendor unique_identifier_msgs
visualization_msgs
"""
_MORE = {
    "jazzy": "domain_coordinator fastrtps fastrtps_cmake_module python_cmake_module",
    "kilted": "ament_cmake_ros_core fastdds rmw_security_common rmw_test_fixture "
    "rmw_test_fixture_implementation",
}
_WHEELS = {name: frozenset((_NAMES + more).split()) for name, more in _MORE.items()}
# The launcher does what they do, or stands for them.
_LAUNCHER = re.compile(r"launch(_(ros|xml|yaml))?|ros2launch")
# Only with an installation of ROS 2: they need rclcpp, or other libraries without a wheel.
_INSTALLED = re.compile(
    r"""
    turtlesim | turtle_tf2_(py|cpp) | turtlebot3(_\w+)? | composition | lifecycle | joy
    | rclcpp(_\w+)? | demo_nodes_\w+ | examples_rcl(cpp|py)_\w+ | action_tutorials_\w+
    | logging_demo | topic_(monitor|tools) | (quality_of_service|intra_process)_demo(_\w+)?
    | robot_(state_publisher|localization) | joint_state_publisher(_gui)? | dummy_robot_bringup
    | rviz(2|_\w+) | rqt(_\w+)? | tf2(_\w+)? | teleop_twist_\w+ | twist_mux | kdl_parser
    | urdf(_(launch|parser_plugin|tutorial))? | (nav2|moveit|ros_gz|rosbag2|realsense2|velodyne)_\w+
    | slam_toolbox | cartographer(_\w+)? | moveit | ros_gz | gazebo_(ros|ros_pkgs|plugins|msgs)
    | controller_(manager|interface) | ros2_control(lers|_test_nodes)? | joint_state_broadcaster
    | (diff_drive|joint_trajectory|mecanum_drive|ackermann_steering|tricycle)_controller
    | (forward_command|effort|velocity|position)_controllers? | hardware_interface
    | image_(transport|proc|view|publisher|pipeline|rotate) | cv_bridge | vision_opencv | usb_cam
    | v4l2_camera | camera_(info_manager|calibration|ros) | depth_image_proc | pcl_(ros|conversions)
    | pointcloud_to_laserscan | laser_(filters|geometry) | apriltag_ros | foxglove_bridge
    | rosbridge_(server|suite|library) | rosapi | ros2(bag|cli|run|topic|node|param|service|action)
    | diagnostic_(aggregator|updater) | domain_bridge
    """,
    re.VERBOSE,
)
# C++ libraries.
_CPP = re.compile(r"rclcpp(_\w+)?|pluginlib|class_loader|rclc|rmw_cyclonedds_cpp")
HOST = "https://github.com"
INSTRUCTIONS = "see docs/reference/interfaces.md"


def clone_commands(*packages: str) -> list[str]:
    """Commands for a workspace's folder that put the sources into `src`; none for others.

    Of a repository with more packages, only their folders: the others may need rclcpp.
    """
    distribution = or_default()
    folders_by_repository: dict[tuple[str, str], list[str]] = {}
    for package in packages:
        if package in SOURCES:
            repository, branch, *given = SOURCES[package].split()
            if branch == "DISTRO":
                branch = _OTHER_BRANCHES.get(distribution, {}).get(repository, distribution)
            folders = [package if folder == "." else folder for folder in given]
            folders_by_repository.setdefault((repository, branch), []).extend(folders)
    commands = []
    for (repository, branch), folders in folders_by_repository.items():
        place = f"src/{repository.rpartition('/')[2]}"
        partly = "--filter blob:none --sparse " if folders else ""
        clone = f"git clone --depth 1 --branch {branch} {partly}{HOST}/{repository} {place}"
        commands.append(clone)
        if folders:
            commands.append(f"git -C {place} sparse-checkout add {' '.join(folders)}")
    return commands


def build_command(package: str) -> str:
    """One line for the shell that gets the sources of a package and builds them."""
    return " && ".join([*clone_commands(package), f"{program()} build"])


def debian(package: str) -> str:
    """The package of apt, for the distribution in use."""
    return f"ros-{or_default()}-{package.replace('_', '-')}"


def wheel(package: str) -> str:
    """The distribution of PyPI, which has the same name; there may be none."""
    return debian(package)


def has_wheel(package: str) -> bool:
    """Whether pip installs it as ros-DISTRO-NAME."""
    return package in _WHEELS.get(or_default(), ())


def is_of_ros(package: str) -> bool:
    """Whether it is a package of ROS 2 with a wheel for any distribution."""
    return any(package in wheels for wheels in _WHEELS.values())


def is_of_launcher(package: str) -> bool:
    """Whether the launcher itself replaces this package."""
    return _LAUNCHER.fullmatch(package) is not None


def is_cpp(package: str) -> bool:
    """Whether it is a library for C++ nodes."""
    return _CPP.fullmatch(package) is not None


def needs_ros(package: str) -> bool:
    """Whether a package is known to come with ROS 2, and neither from PyPI nor from its sources."""
    if package in SOURCES or has_wheel(package):
        return False
    return _INSTALLED.fullmatch(package) is not None or is_of_ros(package)
