from launch import LaunchDescription
from launch.actions import LogInfo, OpaqueFunction, RegisterEventHandler
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition


def times(context):
    event = context.locals.event
    kinds = (isinstance(event.timestamp, int), isinstance(event.stamp.nanosec, int))
    return [LogInfo(msg='%s %s %s' % (event.goal_state, *kinds))]


def generate_launch_description():
    return LaunchDescription([
        RegisterEventHandler(OnStateTransition(entities=[OpaqueFunction(function=times)])),
        LifecycleNode(package='other_pkg', executable='lifecycle_driver', name='n', namespace='',
                      autostart=True),
    ])
