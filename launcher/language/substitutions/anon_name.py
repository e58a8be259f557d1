"""AnonName."""

from __future__ import annotations

import os
import re

from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext


@public("launch.substitutions.anon_name")
class AnonName(Substitution):
    """A name made unique; the same everywhere in the run for the same given name."""

    name: list[Substitution] = read_only()

    def __init__(self, name: object) -> None:
        self.__name = normalize_to_list_of_substitutions(name)

    def describe(self) -> str:
        return f"AnonName({describe_substitutions(self.name)})"

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.name)
        key = "anon" + name
        if key not in context.launch_configurations:
            context.launch_configurations[key] = self.compute_name(name)
        value: str = context.launch_configurations[key]
        return value

    @staticmethod
    def compute_name(id_value: str) -> str:
        """The name with host and process id; the number keeps ROS 2's form."""
        import socket

        name = f"{id_value}_{socket.gethostname()}_{os.getpid()}_{len(id_value)}"
        return re.sub(r"[.\-:]", "_", name)
