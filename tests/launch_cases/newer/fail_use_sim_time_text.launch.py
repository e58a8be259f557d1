from launch import LaunchDescription
from launch_ros.actions import SetUseSimTime


def generate_launch_description():
    return LaunchDescription([SetUseSimTime('true')])
