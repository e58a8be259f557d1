import os

from launch import LaunchDescription
from launch_ros.actions import LoadComposableNodes
from launch_ros.descriptions import ComposableNode

FILE = '''
/*/bar: {ros__parameters: {one: 1}}
/**/bar: {ros__parameters: {any: 2, both: 2}}
/foo/*: {ros__parameters: {in_foo: 3}}
/**: {ros__parameters: {all: 4, both: 4}}
/foo/bar: {ros__parameters: {both: 5}}
/foo/other: {ros__parameters: {no: 6}}
'''


def generate_launch_description():
    path = os.path.join(os.environ['TMPDIR'], 'wild.yaml')
    with open(path, 'w') as file:
        file.write(FILE)
    return LaunchDescription([
        LoadComposableNodes(target_container='/box', composable_node_descriptions=[
            ComposableNode(package='demo_pkg', plugin='demo::P', name='bar', namespace=namespace,
                           parameters=[path])
            for namespace in ('foo', 'deep/foo', '')]),
    ])
