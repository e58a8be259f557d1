from pathlib import PurePosixPath

from launch import LaunchDescription
from launch.actions import LogInfo


def generate_launch_description():
    return LaunchDescription([LogInfo(msg=['x', PurePosixPath('/a')])])
