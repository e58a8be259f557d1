from launch import LaunchDescription
from launch.actions import LogInfo
from launch.substitutions import PathJoinSubstitution

CASES = (['/a', './b', 'd/', ''], ['a//b', '.', 'c'], [], ['..', 'a', '..'], ['a', '/b'],
         ['//a', 'b'], ['///a'], [''])


def generate_launch_description():
    return LaunchDescription([LogInfo(msg=PathJoinSubstitution(one)) for one in CASES])
