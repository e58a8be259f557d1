"""When the parameters of new nodes are compared with those that they declare."""

from __future__ import annotations

from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.events import LoadComponent
    from launcher.posix.reactor import Timer
    from launcher.run.helpers.parameter_check import ParameterCheck
    from launcher.run.process import Process
    from launcher.run.run import Run

# After the start of nodes: comparing their parameters takes CPU time that they need to start.
DELAY_S = 5.0


class ParameterChecks(Part):
    """One for a run."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._processes = run.all_processes.values()
        self._made: ParameterCheck | None = None
        self._timer: Timer | None = None
        self._has_left = False

    def begin(self) -> None:
        for process in self._processes:
            self.added(process)

    def added(self, process: Process) -> None:
        if process.spec.ros or process.spec.members:
            self._later()

    def _later(self) -> None:
        if self._timer is None and not self._has_left:
            self._timer = self._reactor.call_later(DELAY_S, self._check)

    def loaded(self, effect: LoadComponent, full_name: str) -> None:
        if not effect.request.parameters:
            return
        self._check_of_run.add_component(effect, full_name)
        self._later()

    def _check(self) -> None:
        self._timer = None
        if self._has_left:
            return
        self._check_of_run.check(self._processes)
        if any(one.machine.is_pending and one.child is None for one in self._processes):
            self._later()  # those were queued to start

    @property
    def _check_of_run(self) -> ParameterCheck:
        """Imported when the first one is due."""
        if self._made is None:
            from launcher.run.helpers.parameter_check import ParameterCheck

            self._made = ParameterCheck(self._reactor, self.run.env, self.run.log.warn)
        return self._made

    def stopping(self) -> None:
        self._has_left = True
        if self._made is not None:
            self._made.leave()

    def end_helpers(self) -> None:
        if self._made is not None:
            self._made.close()
