from launch import LaunchDescription
from launch_ros.actions import LifecycleNode


def generate_launch_description():
    return LaunchDescription([
        LifecycleNode(package='other_pkg', executable='lifecycle_driver', name='auto', namespace='',
                      autostart='true'),
    ])
