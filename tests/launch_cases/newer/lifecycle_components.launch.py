from launch import LaunchDescription
from launch.actions import LogInfo, RegisterEventHandler
from launch.conditions import IfCondition
from launch.substitutions import TextSubstitution
from launch_ros.actions import ComposableNodeContainer, LifecycleTransition, LoadComposableNodes
from launch_ros.descriptions import ComposableLifecycleNode, ComposableNode
from launch_ros.event_handlers import OnStateTransition
from lifecycle_msgs.msg import Transition


def generate_launch_description():
    def node(name, **options):
        return ComposableLifecycleNode(package='demo_pkg', plugin='demo::L', name=name, **options)
    first = node('first', namespace='inner', autostart=True)
    return LaunchDescription([
        RegisterEventHandler(OnStateTransition(
            target_lifecycle_node=first, goal_state='active',
            entities=[LogInfo(msg='first is active')])),
        ComposableNodeContainer(
            package='other_pkg', executable='component_container', name='box', namespace='ns',
            composable_node_descriptions=[
                ComposableNode(package='demo_pkg', plugin='demo::Talker', name='plain'),
                first,
                node('not', autostart=True, condition=IfCondition('false')),
            ]),
        LoadComposableNodes(target_container='/ns/box', composable_node_descriptions=[
            node('second', autostart=[TextSubstitution(text='true')]),
            node('third')]),
        LifecycleTransition(lifecycle_node_names=['/third'],
                            transition_ids=[Transition.TRANSITION_CONFIGURE]),
    ])
