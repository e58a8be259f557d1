"""What a new evaluation of the launch file means for the processes of a run, as plain data."""

from __future__ import annotations

from launcher.base.model.events import Effect, StartProcess
from launcher.base.model.record import Record
from launcher.base.model.spec import ProcessSpec
from launcher.base.model.spec_diff import Comparable


class Known(Record):
    """A process of the run before the evaluation.

    `has_started`: last `started_ago_s` seconds ago, or its next start is under way. `pid` is None
    if it is not running. `has_ended`, `ended_ago_s` seconds ago: neither a restart nor a user will
    start it again; with `returncode`, unless it could not be started. `is_stopped`:
    a user or the launch file has stopped it. `is_edited`: it is restarted since its files have
    changed. `is_debugged`: it is left as it is, whatever has changed.
    """

    process_id: int
    name: str
    spec: Comparable
    has_started: bool = False
    started_ago_s: float = 0.0
    pid: int | None = None
    has_ended: bool = False
    returncode: int | None = None
    ended_ago_s: float = 0.0
    is_edited: bool = False
    is_stopped: bool = False
    is_debugged: bool = False


class Kept(Record):
    """A process that the new launch file has, too; with `changes` if it is not the same.

    `planned` is its spec without the options of the run. With changes that are `postponed` it runs
    on as it is, for the next reload to find them again.
    """

    process_id: int
    spec: ProcessSpec
    planned: ProcessSpec
    changes: tuple[str, ...] = ()
    postponed: tuple[str, ...] = ()


class Reload(Record):
    """`kept` are in the order of the new launch file, `gone` are process ids.

    `effects` start what is new, and set the timers that are pending. `after` are the effects that
    wait for the restart of a process.
    """

    kept: tuple[Kept, ...]
    gone: tuple[int, ...]
    effects: tuple[Effect, ...]
    after: tuple[tuple[int, tuple[Effect, ...]], ...] = ()

    @property
    def new(self) -> list[ProcessSpec]:
        return [one.spec for one in self.effects if isinstance(one, StartProcess)]

    @property
    def changed(self) -> list[Kept]:
        return [one for one in self.kept if one.changes]

    @property
    def is_empty(self) -> bool:
        """Whether all processes are the same."""
        return not (self.new or self.changed or self.gone)
