from launch import LaunchDescription
from launch.actions import EmitEvent, LogInfo, RegisterEventHandler
from launch.event_handler import EventHandler
from launch import Event


class Mine(Event):
    """An event of this file."""


def generate_launch_description():
    handler = EventHandler(
        matcher=lambda event: isinstance(event, Mine), entities=LogInfo(msg='one'))
    return LaunchDescription([RegisterEventHandler(handler), EmitEvent(event=Mine())])
