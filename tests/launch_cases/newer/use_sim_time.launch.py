from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import SetUseSimTime


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument('sim', default_value='true'),
        SetUseSimTime(True),
        SetUseSimTime(LaunchConfiguration('sim')),
        LogInfo(msg='set'),
    ])
