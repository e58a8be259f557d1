"""One program of the group: its thread, what it was given, and how it has ended."""

from __future__ import annotations

import signal
import sys
import threading
import traceback
import weakref
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from launcher.ros.composed import current, member_output
from launcher.ros.composed.member_program import run_program

if TYPE_CHECKING:
    from rclpy.executors import Executor

    from launcher.ros.composed.context import MemberContext


class Member:
    """`name` is that of the process in the launch file, `argv` its whole command.

    `rclpy_signals` are the signals that rclpy handles for it (SignalHandlerOptions). `exit_code` is
    as in `subprocess`.
    """

    def __init__(self, index: int, name: str, argv: Sequence[str], *, is_essential: bool) -> None:
        self.index = index
        self.name = name
        self.command = tuple(argv)
        self.is_essential = is_essential
        self.argv: list[str] = []
        self.handlers: dict[int, Any] = {}
        self.rclpy_signals: object = None
        self.default_context: MemberContext | None = None
        self.executor: Executor | None = None  # of rclpy.spin
        self.contexts: weakref.WeakSet[MemberContext] = weakref.WeakSet()
        self.nodes: weakref.WeakSet[Any] = weakref.WeakSet()
        self.exit_code: int | None = None
        self.killed_by = 0
        self.is_interrupted = False
        self.lock = threading.RLock()  # nobody interrupts it meanwhile
        self._thread = threading.Thread(target=self._main, name=name, daemon=True)
        self._done: Callable[[Member], None] = lambda one: None

    @property
    def has_ended(self) -> bool:
        return self.exit_code is not None

    @property
    def ident(self) -> int:
        return self._thread.ident or 0

    def start(self, done: Callable[[Member], None]) -> None:
        """Run the program; `done` is called in its thread."""
        self._done = done
        current.belongs_to(self._thread, self)
        self._thread.start()

    def wait(self) -> None:
        self._thread.join()

    def rclpy_shuts_down_at(self, signum: int) -> bool:
        name = getattr(self.rclpy_signals, "name", "NO")
        return {signal.SIGINT: "SIGINT", signal.SIGTERM: "SIGTERM"}.get(
            signal.Signals(signum), "none"
        ) in (("SIGINT", "SIGTERM") if name == "ALL" else (name,))

    def end_contexts(self) -> None:
        """What the handlers of rclpy do at a signal."""
        for context in list(self.contexts):
            context.end_by_signal()

    def wake(self) -> None:
        """Let its executors look at what has happened."""
        for context in list(self.contexts):
            context.wake()

    # ---- in its thread

    def _main(self) -> None:
        code = 1
        try:
            try:
                code = self._run()
            finally:
                with self.lock:  # nor later: it has an exit code
                    self.exit_code = -self.killed_by if self.killed_by else code
        except (KeyboardInterrupt, SystemExit):
            pass  # it came too late
        if self.exit_code is None:
            self.exit_code = code
        self._clean_up()
        self._done(self)

    def _run(self) -> int:
        try:
            run_program(self)
        except SystemExit as end:
            if end.code is None or isinstance(end.code, int):
                return (end.code or 0) & 0xFF
            print(end.code, file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            if not self.is_interrupted:
                self._print_traceback()
            return -int(signal.SIGINT)
        except BaseException:
            self._print_traceback()
            return 1
        return 0

    def _print_traceback(self) -> None:
        kind, error, frames = sys.exc_info()
        while frames is not None and __package__ in frames.tb_frame.f_globals.get("__name__", ""):
            frames = frames.tb_next
        sys.stderr.write("".join(traceback.format_exception(kind, error, frames)))

    def _clean_up(self) -> None:
        """What the end of a process would do."""
        for node in list(self.nodes):
            try:
                node.destroy_node()
            except Exception:
                continue  # it was destroyed, or its context is gone
        for context in list(self.contexts):
            context.try_shutdown()
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, member_output.MemberStream):
                stream.finish(self.index)
