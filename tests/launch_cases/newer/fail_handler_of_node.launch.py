from launch import LaunchDescription
from launch.actions import RegisterEventHandler
from launch_ros.actions import Node
from launch_ros.event_handlers import OnStateTransition


def generate_launch_description():
    node = Node(package='demo_pkg', executable='talker')
    return LaunchDescription([
        RegisterEventHandler(OnStateTransition(target_lifecycle_node=node, entities=[])), node])
