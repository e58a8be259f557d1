from launch import LaunchDescription
from launch.actions import LogInfo
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PathSubstitution

X = LaunchConfiguration('x', default='X')


def generate_launch_description():
    path = PathJoinSubstitution(['/a', ['b_', X, '.yml']])
    return LaunchDescription([LogInfo(msg=one) for one in (
        path, path / 'c' / ['d', X], PathSubstitution(['/a', X]) / 'c', path.describe())])
