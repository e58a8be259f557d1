from launch import LaunchDescription
from launch.actions import ExecuteProcess, LogInfo, SetLaunchConfiguration, TimerAction
from launch.substitutions import LaunchConfiguration

N = LaunchConfiguration('n', default='none')


def generate_launch_description():
    inner = TimerAction(period=1.0, actions=[LogInfo(msg=['inner ', N])])
    return LaunchDescription([
        TimerAction(period=1.0, actions=[
            SetLaunchConfiguration('n', 'outer'), inner,
            ExecuteProcess(cmd=['echo', N], name=['echo_', N]), LogInfo(msg=['outer ', N])]),
        TimerAction(period=1.5, actions=[LogInfo(msg=['beside ', N])]),
    ])
