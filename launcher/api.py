"""`import launcher.api` in a script makes `launch` and `launch_ros` the launcher's own.

import launcher.api  # before `import launch`
from launch import LaunchDescription, LaunchService
from launch.actions import ExecuteProcess

service = LaunchService()
service.include_launch_description(LaunchDescription([ExecuteProcess(cmd=["date"])]))
raise SystemExit(service.run())
"""

import atexit

from launcher.base.model.run_options import RunOptions
from launcher.cli.dispatch import enter_workspace
from launcher.launch.launch_service_run import script_vocabulary
from launcher.packages.distribution import source_installation

source_installation()
enter_workspace()
_vocabulary = script_vocabulary(RunOptions(console=False))
_vocabulary.__enter__()
atexit.register(_vocabulary.__exit__, None, None, None)
