"""The node /launcher of a run (`--ros`): its process is launcher.ros.helpers.bridge."""

from __future__ import annotations

from launcher.base.errors import UsageError
from launcher.run.helpers.client_process import ClientProcess
from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_options import RunOptions
    from launcher.run.run import Run

GOODBYE_S = 4.0  # a bridge that does not exit with the run is killed after this


def check(options: RunOptions) -> None:
    """UsageError without the control socket, or without ROS 2."""
    if not options.control:
        raise UsageError("--ros needs the control socket and excludes --no-control")
    from launcher.packages.absent_ros import require

    require("--ros", {})


class RosBridge(Part):
    """One for a run with a control socket."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        assert run.socket is not None
        self._process = ClientProcess(
            run,
            ("launcher.ros.helpers.bridge", run.socket),
            name="the ROS bridge",
            without="this run is not visible in ROS",
            goodbye_s=GOODBYE_S,
        )

    def begin(self) -> None:
        self._process.start()

    def close(self) -> None:
        self._process.close()
