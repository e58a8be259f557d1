"""Install the fleet: with colcon (ament_python) as well as with pip."""

import glob
import os
import sys

from setuptools import find_packages, setup

PACKAGE = 'group_gp1'
NODES = [
    'dispatcher',
    'robot',
    'robot_1',
    'robot_2',
    'robot_3',
    'monitor',
    'debug_logger',
    'qos_probe',
]
# colcon puts console scripts into lib/group_gp1 (setup.cfg). pip would put them on PATH, where
# `robot` hides that of Robot Framework: there the launcher alone finds them.
# pip says to setuptools by this variable, or by its newer name, what it builds with.
BY_PIP = bool({'PEP517_BUILD_BACKEND', '_PYPROJECT_HOOKS_BUILD_BACKEND'} & os.environ.keys()) or (
    bool({'bdist_wheel', 'dist_info', 'editable_wheel'}.intersection(sys.argv))
)

setup(
    name=PACKAGE,
    version='0.1.0',
    # `launch/` is data: a top-level package `launch` would hide ROS's own in the whole workspace.
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    python_requires='>=3.10',
    install_requires=['ros2-launcher'],
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (
            f'share/{PACKAGE}/launch',
            sorted(glob.glob('launch/*.launch.*') + glob.glob('launch/*.expect.yaml')),
        ),
    ],
    entry_points={
        'launcher.programs' if BY_PIP else 'console_scripts': [
            f'{node} = {PACKAGE}.{node}:main' for node in NODES
        ]
    },
    description='A fleet of warehouse robots',
    license='MIT',
    zip_safe=False,
)
