"""`evaluation.py launcher|ros2 FILE`: CPU seconds from the program's start to the last request.

Nothing is started: only the evaluation is compared. Prints the seconds, and how many processes and
components were requested.
"""

from __future__ import annotations

import asyncio
import gc
import os
import sys
import time
from typing import Any

_QUIET_S = 0.5  # without a further request, the evaluation is over


def launcher(path: str) -> tuple[float, int, int]:
    """As a run evaluates it."""
    gc.disable()  # as the program does
    from launcher.base.model.events import LoadComponent, StartProcess
    from launcher.language import frontends
    from launcher.language.compat import vocabulary
    from launcher.language.interpreter import Interpreter

    with vocabulary([path]):
        interpreter = Interpreter(frontends.load(path), path=path)
        effects = interpreter.start()
        used = time.process_time()
        interpreter.close()
    loads = [1 + len(one.rest) for one in effects if isinstance(one, LoadComponent)]
    return used, sum(isinstance(one, StartProcess) for one in effects), sum(loads)


def ros2(path: str) -> tuple[float, int, int]:
    """With the packages of ROS 2, in which starting and loading are replaced."""
    from launch import LaunchDescription, LaunchService
    from launch.actions import ExecuteLocal, IncludeLaunchDescription
    from launch.launch_description_sources import AnyLaunchDescriptionSource
    from launch_ros.actions import load_composable_nodes

    times: list[float] = []
    loads: list[Any] = []

    async def spawn(self: Any, context: Any) -> None:
        times.append(time.process_time())
        await asyncio.Event().wait()

    process: Any = ExecuteLocal
    process._ExecuteLocal__execute_process = spawn
    loading: Any = load_composable_nodes
    loading.LoadComposableNodes._load_in_sequence = lambda self, some, context: loads.extend(some)
    loading.get_ros_node = lambda context: _Node()
    service = LaunchService(noninteractive=True)
    include = IncludeLaunchDescription(AnyLaunchDescriptionSource(path))
    service.include_launch_description(LaunchDescription([include]))

    async def until_quiet() -> None:
        run = asyncio.ensure_future(service.run_async())
        before = -1
        while (len(times) > before or not times) and not run.done():
            before = len(times)
            await asyncio.sleep(_QUIET_S)

    asyncio.new_event_loop().run_until_complete(until_quiet())
    return times[-1], len(times), len(loads)


class _Node:
    """Stands for the node that calls containers."""

    def create_client(self, *words: object) -> None:
        return None


if __name__ == "__main__":
    evaluate = {"launcher": launcher, "ros2": ros2}[sys.argv[1]]
    print("found", *evaluate(sys.argv[2]), flush=True)
    os._exit(0)  # the processes of ROS 2 would never end
