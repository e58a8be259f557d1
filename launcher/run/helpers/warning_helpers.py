"""Helper processes that look at a ROS domain for a while, and warn.

Each ends by itself, and is killed with the run, before leftovers are looked for; shared memory that
it may have is freed as that of nodes.
"""

from __future__ import annotations

from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping

    from launcher.run.helpers.json_lines import JsonLinesProcess
    from launcher.run.run import Run


class WarningHelpers(Part):
    """A part with such processes of one program; the texts that they write are warnings."""

    program: str

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._helpers: list[JsonLinesProcess] = []
        self._has_left = False

    def start_helper(self, env: Mapping[str, str], request: Mapping[str, object]) -> None:
        from launcher.run.helpers.json_lines import (
            JsonLinesProcess,
            own_end,
            without_shared_memory,
        )

        try:
            helper = JsonLinesProcess(
                self.run.reactor,
                self.program,
                without_shared_memory(own_end(env)),
                on_message=self.run.log.warn,
                on_end=lambda code, line: self._helpers.remove(helper),
            )
        except OSError:
            return  # there is no warning, and nothing else is missing
        self._helpers.append(helper)
        helper.send(request)

    def stopping(self) -> None:
        """Let the helpers end."""
        self._has_left = True
        for helper in self._helpers:
            helper.close_input()

    def end_helpers(self) -> None:
        for helper in self._helpers:
            helper.close()
        self._helpers.clear()
