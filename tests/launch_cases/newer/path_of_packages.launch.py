from launch import LaunchDescription
from launch.actions import LogInfo
from launch.substitutions import LaunchLogDir, ThisLaunchFileDir
from launch_ros.substitutions import FindPackagePrefix, FindPackageShare


def generate_launch_description():
    return LaunchDescription([LogInfo(msg=one) for one in (
        FindPackageShare('demo_pkg') / 'config' / 'params.yaml',
        FindPackagePrefix('demo_pkg') / ['li', 'b'],
        ThisLaunchFileDir() / 'x', LaunchLogDir() / 'x')])
