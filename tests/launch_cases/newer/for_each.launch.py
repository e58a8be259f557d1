from launch import LaunchDescription
from launch.actions import ForEach, ForLoop, LogInfo


def each(name, size=2):
    return [LogInfo(msg=f'{name} {size * 2}')]


def index(i):
    return [LogInfo(msg=str(i))] if i else None


def generate_launch_description():
    return LaunchDescription([
        ForEach('{name: A, size: 5};{name: B}', function=each), ForLoop(3, function=index)])
