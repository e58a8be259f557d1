from launch import LaunchDescription
from launch.actions import LogInfo
from launch.substitutions import AllSubstitution, AnySubstitution


def generate_launch_description():
    return LaunchDescription([LogInfo(msg=[
        AnySubstitution('false', container=['0', 'true']), ' ',
        AllSubstitution('true', container=['0']), ' ',
        AllSubstitution(container=[]), ' ', AnySubstitution(container=())])])
