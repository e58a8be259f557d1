"""What rclpy is to a member: its own default context, on the participant that all share.

A context of rmw_fastrtps is a participant of DDS with ten threads and its shared memory. The nodes
of all members are in one, and get the arguments of their member as arguments of the node.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import weakref
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import rclpy
import rclpy.executors
import rclpy.logging
import rclpy.node
import rclpy.signals
import rclpy.utilities
from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation

from launcher.ros.composed import control, current
from launcher.ros.composed.member import Member
from launcher.ros.composed.member_arguments import log_levels, node_arguments

if TYPE_CHECKING:
    from rclpy.node import Node

_lock = threading.RLock()
_shared: Context | None = None


def shared() -> Context:
    """The context of the participant; made when the first member needs it."""
    global _shared
    with _lock:
        if _shared is None:
            _shared = Context()
            _shared.init([])
        return _shared


def close_shared() -> None:
    if _shared is not None:
        _shared.try_shutdown()


class MemberContext(Context):  # type: ignore[misc]  # rclpy has no types
    """The context of a member. For another domain it is a separate context."""

    def __init__(self, member: Member) -> None:
        super().__init__()
        self.member = member
        self.arguments: list[str] = []
        self.levels: list[tuple[str, int]] = []
        self._is_up: bool | None = None  # None: before init
        self._is_own = False
        self._wakers: list[weakref.WeakMethod[Callable[[], None]]] = []
        member.contexts.add(self)

    @property
    def handle(self) -> Any:
        return super().handle if self._is_own else self._is_up is not None and shared().handle

    def init(
        self,
        args: Sequence[str] | None = None,
        *,
        initialize_logging: bool = True,
        domain_id: int | None = None,
    ) -> None:
        if self._is_up is not None:
            raise RuntimeError("Context.init() must only be called once")
        words = list(sys.argv if args is None else args)
        if domain_id is not None and domain_id != shared().get_domain_id():
            self._is_own = True
            super().init(words, initialize_logging=initialize_logging, domain_id=domain_id)
        self.arguments = node_arguments(words)
        self.levels = log_levels(words)
        for logger, level in self.levels:
            if logger:
                rclpy.logging.set_logger_level(logger, level)
        shared()
        self._is_up = True

    def ok(self) -> bool:
        return bool(self._is_up) and (super().ok() if self._is_own else shared().ok())

    def shutdown(self) -> None:
        if self._is_up is None:
            raise RuntimeError("Context must be initialized before it can be shutdown")
        if not self._is_up:
            raise rclpy_implementation.RCLError(
                "failed to shutdown: rcl_shutdown already called on the given context"
            )
        self.try_shutdown()

    def try_shutdown(self) -> None:
        if not self._is_up:
            return
        self._is_up = False
        if self._is_own:
            super().try_shutdown()
            return
        with self._lock:
            self._call_on_shutdown_callbacks()
        self.wake()

    def end_by_signal(self) -> None:
        """As the handlers of rclpy: without the callbacks, which only Python's shutdown calls."""
        if self._is_own:
            self.try_shutdown()
        elif self._is_up:
            self._is_up = False
            self.wake()

    def on_shutdown(self, callback: Callable[[], None]) -> None:
        if isinstance(getattr(callback, "__self__", None), rclpy.executors.Executor):
            self._wakers.append(weakref.WeakMethod(callback))
        if self._is_own or self._is_up is None:
            super().on_shutdown(callback)
        elif not self._is_up:
            callback()
        elif hasattr(callback, "__self__"):
            self._callbacks.append(weakref.WeakMethod(callback, self._remove_callback))
        else:
            self._callbacks.append(callback)

    def wake(self) -> None:
        """Let its executors see that something has happened."""
        for waker in self._wakers:
            wake = waker()
            if wake is not None:
                with contextlib.suppress(rclpy_implementation.InvalidHandle, AttributeError):
                    wake()  # fails if its thread shuts it down meanwhile

    def get_domain_id(self) -> int:
        domain_id = super().get_domain_id() if self._is_own else shared().get_domain_id()
        return int(domain_id)


# ---- instead of functions of rclpy


def _get_default_context(*, shutting_down: bool = False) -> Any:
    one = current.member()
    if one is None:
        return _own["get_default_context"](shutting_down=shutting_down)
    with _lock:
        if one.default_context is None:
            one.default_context = MemberContext(one)
        found = one.default_context
        if shutting_down:
            one.default_context = None
        return found


def _try_shutdown(*, context: object = None) -> None:
    one = current.member()
    if context is not None or one is None:
        _own["try_shutdown"](context=context)
        return
    default = _get_default_context()
    default.try_shutdown()
    if not default.ok():
        one.default_context = None


def _get_global_executor() -> Any:
    """That of `rclpy.spin`, which lasts as long as the default context."""
    one = current.member()
    if one is None:
        return _own["get_global_executor"]()
    if one.executor is None:
        one.executor = rclpy.executors.SingleThreadedExecutor()

        def reset() -> None:
            if one.executor is not None:
                one.executor.shutdown()
                one.executor = None

        _get_default_context().on_shutdown(reset)
    return one.executor


def _install_signal_handlers(options: object = rclpy.signals.SignalHandlerOptions.ALL) -> None:
    one = current.member()
    if one is None:
        _own["install_signal_handlers"](options)
    elif options != rclpy.signals.SignalHandlerOptions.NO:
        one.rclpy_signals = options


def _uninstall_signal_handlers() -> None:
    one = current.member()
    if one is None:
        _own["uninstall_signal_handlers"]()
    else:
        one.rclpy_signals = None


def _get_current_signal_handlers_options() -> Any:
    one = current.member()
    if one is None:
        return _own["get_current_signal_handlers_options"]()
    return one.rclpy_signals or rclpy.signals.SignalHandlerOptions.NO


_INSTEAD: dict[str, Callable[..., Any]] = {
    "get_default_context": _get_default_context,
    "try_shutdown": _try_shutdown,
    "get_global_executor": _get_global_executor,
    "install_signal_handlers": _install_signal_handlers,
    "uninstall_signal_handlers": _uninstall_signal_handlers,
    "get_current_signal_handlers_options": _get_current_signal_handlers_options,
}
_HOMES = {"get_global_executor": rclpy, "get_default_context": rclpy.utilities}
_HOMES["try_shutdown"] = rclpy.utilities
_own = {name: getattr(_HOMES.get(name, rclpy.signals), name) for name in _INSTEAD}


def install() -> None:
    """Put these functions into all modules of rclpy that have the original; before any member."""
    for module in [module for name, module in sys.modules.items() if name.startswith("rclpy")]:
        for name, instead in _INSTEAD.items():
            if getattr(module, name, None) is _own[name]:
                setattr(module, name, instead)
    _own_init = rclpy.node.Node.__init__

    def init_node(node: Node, node_name: str, *positional: object, **options: Any) -> None:
        context = options.get("context") or _get_default_context()
        if not isinstance(context, MemberContext) or context._is_own:
            _own_init(node, node_name, *positional, **options)
            _introduce(node, current.member(), ())
            return
        own = options.get("cli_args") or []
        if options.get("use_global_arguments", True):
            # Of remappings the first one counts, of parameters the last.
            options["cli_args"] = [*own, *context.arguments, *own]
        options["use_global_arguments"] = False
        with _lock:  # rcl has tables of nodes without locks
            _own_init(node, node_name, *positional, **options)
        _introduce(node, context.member, context.levels)

    rclpy.node.Node.__init__ = init_node


def _introduce(node: Node, one: Member | None, levels: Iterable[tuple[str, int]]) -> None:
    """Report the node to the launcher; its logger may log from now on."""
    if one is None:
        return
    logger = node.get_logger().name
    for name, level in levels:
        if not name:
            rclpy.logging.set_logger_level(logger, level)
    one.nodes.add(node)
    control.send(one.index, "node", node.get_fully_qualified_name(), logger)
