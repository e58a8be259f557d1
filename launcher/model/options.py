"""RunOptions: what a person wants of a run beyond what its launch file says."""

from __future__ import annotations

import fnmatch

from launcher.model.record import Record, replace
from launcher.model.spec import ProcessSpec, RestartPolicy


class RunOptions(Record):
    """`restart` are (pattern, policy) pairs, the last that matches counts.

    `required` are patterns of processes without which the run ends; `timeout_s` ends it after a
    time; `exit_when_any_dies` after the first death that is not followed by a restart. `budgets`
    and `budget_file` are limits on resources (`engine.budget_reader` reads them). `control`: other
    shells may look at the run and steer it.
    """

    restart: tuple[tuple[str, RestartPolicy], ...] = ()
    required: tuple[str, ...] = ()
    exit_when_any_dies: bool = False
    timeout_s: float | None = None
    log_files: bool = True
    control: bool = True
    budgets: tuple[str, ...] = ()
    budget_file: str | None = None

    def adapt(self, spec: ProcessSpec) -> ProcessSpec:
        """The spec as these options want it."""
        for pattern, policy in self.restart:
            if matches(pattern, spec):
                spec = replace(spec, restart=policy)
        return spec

    def is_required(self, spec: ProcessSpec) -> bool:
        """Whether the run ends with this process."""
        return any(matches(pattern, spec) for pattern in self.required)


def matches(pattern: str, spec: ProcessSpec) -> bool:
    """Whether a pattern (`robot_*`) means this process: by name, label or node name."""
    names = [spec.name, spec.label]
    if spec.ros is not None and spec.ros.node_name is not None:
        names += [spec.ros.node_name, spec.ros.node_name.rpartition("/")[2]]
    return any(fnmatch.fnmatchcase(name, pattern) for name in names)
