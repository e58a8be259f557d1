"""When the parameters of new nodes are compared with those that they declare."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from launcher.posix.reactor import Reactor, Timer
from launcher.run.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.events import LoadComponent
    from launcher.run.helpers.parameter_check import ParameterCheck

# After the start of nodes: comparing their parameters takes CPU time that they need to start.
DELAY_S = 5.0


class ParameterChecks:
    """`processes` is the live collection of those of the run."""

    def __init__(
        self,
        reactor: Reactor,
        env: Mapping[str, str],
        warn: Callable[[str], None],
        processes: Collection[Process],
    ) -> None:
        self._reactor = reactor
        self._env = env
        self._warn = warn
        self._processes = processes
        self._made: ParameterCheck | None = None
        self._timer: Timer | None = None
        self._has_left = False

    def later(self) -> None:
        """A node was started."""
        if self._timer is None and not self._has_left:
            self._timer = self._reactor.call_later(DELAY_S, self._check)

    def loaded(self, effect: LoadComponent, full_name: str) -> None:
        """A container has loaded this node, which has parameters."""
        self._check_of_run.add_component(effect, full_name)
        self.later()

    def _check(self) -> None:
        self._timer = None
        if self._has_left:
            return
        self._check_of_run.check(self._processes)
        if any(one.machine.is_pending and one.child is None for one in self._processes):
            self.later()  # those were queued to start

    @property
    def _check_of_run(self) -> ParameterCheck:
        """Imported when the first one is due."""
        if self._made is None:
            from launcher.run.helpers.parameter_check import ParameterCheck

            self._made = ParameterCheck(self._reactor, self._env, self._warn)
        return self._made

    def leave(self) -> None:
        """The run is being stopped."""
        self._has_left = True
        if self._made is not None:
            self._made.leave()

    def close(self) -> None:
        if self._made is not None:
            self._made.close()
