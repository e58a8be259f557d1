"""The interface between entities and the interpreter that runs them."""

from __future__ import annotations

from collections.abc import Callable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Protocol

    from launcher.language.diagnostics.origin import FileLine
    from launcher.language.events.base import Event

    class EntityHost(Protocol):
        """Requests of entities; none blocks, and none takes effect before the visit ends.

        `shutdown_pending` is true from the request of a shutdown to its handling.
        """

        shutdown_pending: bool

        def accepts(self, event: Event) -> bool:
            """Whether an emitted event is to be queued."""

        def later(self, step: Callable[[], None]) -> None:
            """Run `step` after the current event was handled, in order of the requests."""

        def next_process_number(self) -> int:
            """The number of the next process of this run, from 1."""

        def spawn(self, action: Any) -> None:
            """Start the process of this action (an ExecuteLocal that is prepared)."""

        def request(self, effect: Any) -> None:
            """Hand an effect to the driver, in order."""

        def process_of(self, action: Any) -> int | None:
            """The process_id of the action while its process runs or will be restarted."""

        def call_later(
            self,
            delay_s: float,
            callback: Callable[[], None],
            *,
            outlives_shutdown: bool = False,
            on_ros_clock: bool = False,
            action: Any = None,
        ) -> int:
            """Call `callback` after `delay_s` seconds; the result is for `cancel_call`.

            If it outlives a shutdown, the run does not end before. `action` is the timer of the
            launch file, if it is one.
            """

        def cancel_call(self, timer_id: int) -> None:
            """Cancel a `call_later`."""

        def log(self, logger: str, level: str, text: str) -> None:
            """Print `[LEVEL] [logger]: text`."""

        def visiting(self, entity: object) -> None:
            """The visit of an entity begins; entities visited before its end are its children."""

        def visited(self) -> None:
            """The visit that began last has ended."""

        def skipped(self, action: Any) -> None:
            """The condition of an action was false."""

        def warn_quirk(self, text: str, origin: FileLine | None) -> None:
            """Warn about surprising behaviour that was copied from ROS 2."""

        def configuration_read(self, name: str) -> None:
            """The launch file reads this launch configuration."""

        def configuration_written(self, name: str, value: object, origin: FileLine | None) -> None:
            """A launch configuration was set at `origin` (None: on the command line)."""

        def declared(self, argument: object, value: str) -> None:
            """The declaration of a launch argument was executed; `value` is its value."""

        def remember_file(self, path: str, content: object, source: str | None = None) -> None:
            """Register a generated parameter file: shown in plans, deleted after the run.

            `source` is the file of which the substitutions were replaced.
            """

        def uses_parameter_file(self, path: str, node: str | None, origin: FileLine | None) -> None:
            """A component with this full name gets a parameter file; None: it is not known."""

        def load_component(
            self,
            request: object,
            done: Callable[[Any], None],
            origin: FileLine | None = None,
            rest: tuple[Any, ...] = (),
        ) -> None:
            """Ask a container to load a node, described at `origin`; `done` gets the answer.

            `rest` are those that will follow.
            """

        def change_state(self, request: object, done: Callable[[Any], None]) -> None:
            """Ask a lifecycle node for a transition; `done` gets the answer event."""

        def watch_lifecycle(self, node: str, seen: Callable[[Any], None]) -> None:
            """Call `seen` with each TransitionSeen of this node."""

        def asyncio_loop(self) -> Any:
            """An asyncio event loop driven by the timers of the run."""


class NullHost:
    """Accepts every request and does nothing, for a LaunchContext that a launch file creates."""

    def __init__(self) -> None:
        self._processes = 0
        self.shutdown_pending = False

    def accepts(self, event: Event) -> bool:
        return True

    def next_process_number(self) -> int:
        self._processes += 1
        return self._processes

    def process_of(self, action: Any) -> int | None:
        return None

    def call_later(self, delay_s: float, callback: Callable[[], None], **options: Any) -> int:
        return 0

    def asyncio_loop(self) -> Any:
        """None, as in ROS 2 before the run starts."""
        return None

    def _ignore(self, *args: object, **kwargs: object) -> None:
        pass

    later = spawn = request = cancel_call = log = _ignore
    visiting = visited = skipped = warn_quirk = _ignore
    configuration_read = configuration_written = declared = remember_file = _ignore
    uses_parameter_file = load_component = change_state = watch_lifecycle = _ignore
