from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, IncludeLaunchDescription, LogInfo
from launch.actions import SetEnvironmentVariable, SetLaunchConfiguration
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import FileContent, LaunchConfiguration, PathJoinSubstitution
from launch.substitutions import PathSubstitution
from launch_ros.actions import Node

HERE = Path(__file__).parent


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument('d', default_value=Path('/d/e')),
        SetLaunchConfiguration('c', [Path('/c'), '/x']),
        LogInfo(msg=Path('/a//b/')),
        LogInfo(msg=[Path('/a'), '/', LaunchConfiguration('d'), LaunchConfiguration('c')]),
        LogInfo(msg=PathJoinSubstitution([Path('/a'), [Path('b'), '.yml']]) / Path('c')),
        LogInfo(msg=PathSubstitution(Path('/a')) / 'b'),
        LogInfo(msg=FileContent(HERE / 'text.txt')),
        SetEnvironmentVariable('PLACE', Path('/e')),
        ExecuteProcess(cmd=['ls', Path('/l')], cwd=Path('/'), additional_env={'P': Path('/p')}),
        Node(package='demo_pkg', executable='talker', arguments=['-d', Path('/a/b')]),
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(HERE / 'path_child.launch.py'),
            launch_arguments={'given': Path('/g')}.items()),
        IncludeLaunchDescription(HERE / 'path_child.launch.py'),
    ])
