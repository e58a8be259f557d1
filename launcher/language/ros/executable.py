"""RosExecutable and Node descriptions: an executable with one or more ROS nodes in it."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.executable import Executable
from launcher.language.naming import public
from launcher.language.ros.packages import ExecutableInPackage

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch_ros.descriptions.ros_executable")
class RosExecutable(Executable):
    """An executable with ROS nodes, for `launch.actions.ExecuteLocal`."""

    def __init__(
        self,
        *,
        executable: Any = None,
        package: Any = None,
        nodes: Iterable[Any] | None = None,
        **kwargs: Any,
    ) -> None:
        program = executable
        if package is not None:
            program = ExecutableInPackage(package=package, executable=executable)
        self.__package = package
        self.__executable = executable
        self.__nodes = nodes
        super().__init__(cmd=[program], **kwargs)

    @property
    def package(self) -> Any:
        """The package."""
        return self.__package

    @property
    def executable(self) -> Any:
        """The executable."""
        return self.__executable

    @property
    def nodes(self) -> Any:
        """The nodes."""
        return self.__nodes

    def prepare(self, context: LaunchContext, action: Any) -> None:
        """Prepare the nodes, then the command."""
        for node in self.__nodes or ():
            node.prepare(context, self, action)
        super().prepare(context, action)
