"""Starts `launcher.ros.helpers.namesakes`, which looks for nodes of others with our names.

Beside the start of the run, which does not wait for it; for runs with ROS nodes only.
"""

from __future__ import annotations

import os

from launcher.base.model.ros_arguments import full_node_name
from launcher.run.helpers.helper_programs import NAMESAKES
from launcher.run.helpers.warning_helpers import WarningHelpers

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping


class NamesakeChecks(WarningHelpers):
    """One helper for each domain, once."""

    program = NAMESAKES

    def begin(self) -> None:
        if self._has_left:
            return
        environments: dict[str, Mapping[str, str]] = {}
        names: dict[str, list[str | None]] = {}
        for process in self.run.processes:
            for spec in process.spec.members or (process.spec,):
                if spec.ros is not None and process.host is None:
                    domain = spec.env.get("ROS_DOMAIN_ID") or "0"
                    environments.setdefault(domain, spec.env)
                    names.setdefault(domain, []).append(full_node_name(spec.argv))
        for domain, found in names.items():
            request = {"run": self.run.id, "launcher": os.getpid(), "names": found}
            self.start_helper(environments[domain], request)
