"""Errors about packages and executables that are not found."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence

from launcher.errors import PackageNotFoundError
from launcher.packages import sources
from launcher.packages.sources import MARKERS, OVERLAY_FOLDER
from launcher.program import program
from launcher.text import did_you_mean

# Of ROS 2's distribution, without a wheel for pip.
_WITHOUT_WHEEL = re.compile(
    r"""
    turtlesim | turtle_tf2_(py|cpp) | turtlebot3(_\w+)? | xacro | composition | lifecycle | joy
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
    | diagnostic_(aggregator|updater) | domain_bridge | control_msgs | vision_msgs
    """,
    re.VERBOSE,
)


def needs_ros(package: str) -> bool:
    """Whether a package is known to come with ROS 2, and not from PyPI."""
    return _WITHOUT_WHEEL.fullmatch(package) is not None


def package_not_found(
    name: str, known: Iterable[str], prefixes: Sequence[os.PathLike[str]]
) -> PackageNotFoundError:
    """The error, with the nearest name, or where the package comes from."""
    if name == "foxglove_bridge":
        hint: str | None = f"`{program()} foxglove` does the same, without this package"
    elif needs_ros(name):
        debian = f"ros-jazzy-{name.replace('_', '-')}"
        hint = (
            f"it has no wheel, but comes with an installation of ROS 2 (apt install {debian}): "
            f"source its setup.bash; `{program()}` runs there as well"
        )
    else:
        hint = (
            _lost_hint(name, prefixes)
            or _manifest_hint(name)
            or did_you_mean(name, sorted(known))
            or _searched(prefixes)
        )
    return PackageNotFoundError(f"package '{name}' not found", hint=hint)


def _lost_hint(name: str, prefixes: Iterable[os.PathLike[str]]) -> str | None:
    """Why a package that is installed as links is not found: what they lead to is gone."""
    for prefix in prefixes:
        marker = os.path.join(prefix, MARKERS, name)
        if os.path.islink(marker):
            return (
                f"it is installed in {prefix}, as links to {os.path.realpath(marker)}, which is "
                f"gone: put the source back, or remove what is installed; `{program()} doctor` "
                "names the command"
            )
    return None


def _searched(prefixes: Iterable[os.PathLike[str]]) -> str:
    shown = (path for path in map(str, prefixes) if OVERLAY_FOLDER not in path)
    places = "editable installations, and source folders around the working directory"
    return f"searched: {', '.join(shown)}, {places}"


def _manifest_hint(name: str) -> str | None:
    """What is wrong with the package.xml of a source folder that is called like the package."""
    folder = sources.without_name(name)
    if folder is None:
        return None
    file = os.path.join(folder, "package.xml")
    if not os.path.isfile(file):
        return f"{folder}/ has no package.xml"
    from xml.etree import ElementTree

    try:
        ElementTree.parse(file)
    except (ElementTree.ParseError, OSError) as error:
        return f"{file} could not be read: {error}"
    return f"{file} has no <name>"


def no_executable_hint(
    package: str, names: Iterable[str], source: str | None, problem: str | None
) -> str:
    """What a package has instead, or why a source folder has nothing."""
    listed = ", ".join(sorted(names))
    if listed or source is None:
        return f"executables of {package}: {listed or 'none'}"
    if problem is not None:
        return f"{source}/setup.py could not be read: {problem}"
    if os.path.isfile(os.path.join(source, "CMakeLists.txt")):
        return f"{source} is not built: {program()} build"
    return f"{source}/setup.py has no console_scripts in its entry_points"
