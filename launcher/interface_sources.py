"""Where well-known packages of interfaces are that have no wheel, and how to get their sources.

Repositories and branches are those of ROS 2 Jazzy's list of packages (rosdistro).
"""

from __future__ import annotations

# Package -> repository on GitHub, branch, and its folders where it is not the whole repository.
_SOURCES = {
    "ackermann_msgs": "ros-drivers/ackermann_msgs ros2",
    "action_tutorials_interfaces": "ros2/demos jazzy action_tutorials/action_tutorials_interfaces",
    "ament_cmake_auto": "ament/ament_cmake jazzy ament_cmake_auto",
    "apriltag_msgs": "christianrauch/apriltag_msgs master",
    "composition_interfaces": "ros2/rcl_interfaces jazzy composition_interfaces",
    "control_msgs": "ros-controls/control_msgs jazzy control_msgs",
    "controller_manager_msgs": "ros-controls/ros2_control jazzy controller_manager_msgs",
    "example_interfaces": "ros2/example_interfaces jazzy",
    "foxglove_msgs": "foxglove/foxglove-sdk main ros/src/foxglove_msgs schemas/ros2",
    "geographic_msgs": "ros-geographic-info/geographic_info ros2 geographic_msgs",
    "gps_msgs": "swri-robotics/gps_umd ros2-devel gps_msgs",
    "grid_map_msgs": "ANYbotics/grid_map jazzy grid_map_msgs",
    "map_msgs": "ros-planning/navigation_msgs jazzy map_msgs",
    "moveit_msgs": "moveit/moveit_msgs ros2",
    "nav2_common": "ros-navigation/navigation2 jazzy nav2_common",
    "nav2_msgs": "ros-navigation/navigation2 jazzy nav2_msgs",
    "nmea_msgs": "ros-drivers/nmea_msgs ros2",
    "object_recognition_msgs": "wg-perception/object_recognition_msgs ros2",
    "octomap_msgs": "OctoMap/octomap_msgs ros2",
    "pendulum_msgs": "ros2/demos jazzy pendulum_msgs",
    "pcl_msgs": "ros-perception/pcl_msgs ros2",
    "rmf_dispenser_msgs": "open-rmf/rmf_internal_msgs jazzy rmf_dispenser_msgs",
    "rmf_door_msgs": "open-rmf/rmf_internal_msgs jazzy rmf_door_msgs",
    "rmf_fleet_msgs": "open-rmf/rmf_internal_msgs jazzy rmf_fleet_msgs",
    "rmf_lift_msgs": "open-rmf/rmf_internal_msgs jazzy rmf_lift_msgs",
    "rmf_task_msgs": "open-rmf/rmf_internal_msgs jazzy rmf_task_msgs",
    "rosbag2_interfaces": "ros2/rosbag2 jazzy rosbag2_interfaces",
    "statistics_msgs": "ros2/rcl_interfaces jazzy statistics_msgs",
    "tf2_msgs": "ros2/geometry2 jazzy tf2_msgs",
    "velodyne_msgs": "ros-drivers/velodyne ros2 velodyne_msgs",
    "vision_msgs": "ros-perception/vision_msgs ros2 vision_msgs",
}
HOST = "https://github.com"
INSTRUCTIONS = "see docs/interfaces.md"


def known_packages() -> list[str]:
    return sorted(_SOURCES)


def clone_commands(*packages: str) -> list[str]:
    """Commands for a workspace's folder that put the sources into `src`; none for others.

    Of a repository with more packages, only their folders: the others may need rclcpp.
    """
    folders_by_repository: dict[tuple[str, str], list[str]] = {}
    for package in packages:
        if package in _SOURCES:
            repository, branch, *folders = _SOURCES[package].split()
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
