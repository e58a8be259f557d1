from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument('auto', default_value='maybe'),
        LifecycleNode(package='other_pkg', executable='lifecycle_driver', name='auto', namespace='',
                      autostart=LaunchConfiguration('auto')),
    ])
