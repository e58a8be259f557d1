"""Imports what programs need, and finds out which imports are no good in a process that forks.

An import may start threads, which a forked process would lack, or do what is seen only once:
write, open files, start processes, change the environment, signal handlers or the search path.
Such a module is left out by a new preparing process, since what it did cannot be undone; programs
import it themselves then.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import os
import signal
import sys
from types import ModuleType

from launcher.base import strict_json
from launcher.posix import proc
from launcher.run.warm import forking
from launcher.run.warm.forking import Forker

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from typing import Any

    Found = tuple[list[str], list[tuple[str, str]]]


_ROS = "rclpy"
_ROS_MODULES = (
    "rclpy",
    "rclpy.executors",
    "rclpy.impl.implementation_singleton",
    "rclpy.node",
    "rclpy.type_support",
)
_INTERFACES = ("msg", "srv", "action")
# Every node has the services of its parameters and type descriptions, and publishes its log.
_TYPES_OF_NODES = (
    ("rcl_interfaces.msg", "Log"),
    ("rcl_interfaces.msg", "ParameterEvent"),
    ("rcl_interfaces.srv", "DescribeParameters"),
    ("rcl_interfaces.srv", "GetParameterTypes"),
    ("rcl_interfaces.srv", "GetParameters"),
    ("rcl_interfaces.srv", "ListParameters"),
    ("rcl_interfaces.srv", "SetParameters"),
    ("rcl_interfaces.srv", "SetParametersAtomically"),
    ("type_description_interfaces.srv", "GetTypeDescription"),
)
# Not worth it, or with effects on the terminal or the browser.
_NOT_PREPARED = ("__future__", "antigravity", "idlelib", "readline", "rlcompleter", "this")


class Preparation:
    """One pass over all imports; `step(name)` is called before each.

    `added` are the variables that the interpreter itself has set, `tracing` the library whose
    threads a fork has to restore.
    """

    def __init__(
        self, request: Mapping[str, Any], scan: Scan, step: Callable[[str], object]
    ) -> None:
        self._scan = scan
        self._expects_ros: bool = request["ros"]
        self._without = tuple(request.get("without", ()))
        self._step = step
        self._variables: set[str] = set()
        self._unwanted: list[str] = []
        self._output = _captured_output()
        given: Mapping[str, str] = request["environment"]
        self.added = {k: v for k, v in os.environ.items() if given.get(k) != v}
        self.tracing: forking.Tracing | None = None

    def run(self) -> list[str]:
        """Import everything; the modules that are to be left out from now on.

        The imports of nodes are known before the scan has found them.
        """
        with _recorded_variables(self._variables):
            if self._expects_ros:
                self._import_ros()
            names, types = self._scan.result()
            if _ROS in names:
                self._import_ros()
            for name in names:
                is_known = name in sys.modules
                if not is_known and name.partition(".")[0] not in (*_NOT_PREPARED, *self._without):
                    self._checked(name, functools.partial(importlib.import_module, name))
            if _ROS in sys.modules and not self._unwanted:
                self._checked(_ROS, functools.partial(_load_types, types))
                _find_files()
        return [*self._without, *self._unwanted] if self._unwanted else []

    def result(self) -> dict[str, Any]:
        """What the launcher has to know to judge a start."""
        tops = {name.partition(".")[0] for name in sys.modules}
        return {
            "variables": sorted(self._variables),
            "modules": sorted(tops - {"__main__"}),
            "without": list(self._without),
        }

    def _checked(self, name: str, load: Callable[[], object]) -> None:
        """Load it, and note what it is part of if it did what a fork does not repeat."""
        self._step(name)
        before = _State(self._output)
        with contextlib.suppress(Exception, SystemExit):  # the program will see the same error
            load()
        after = _State(self._output)
        is_seen_once = after != before and name != _ROS
        has_threads = len(after.threads) != len(before.threads)
        if is_seen_once or (has_threads and not self._survives_fork()):
            self._unwanted.append(name.partition(".")[0])

    def _import_ros(self) -> None:
        if _ROS not in (*sys.modules, *self._without, *self._unwanted):
            self._checked(_ROS, _load_ros)

    def _survives_fork(self) -> bool:
        """Whether a forked process has the threads that there are now.

        Some libraries end their threads before a fork and start them when they are needed next.
        """
        self.tracing = self.tracing or forking.loaded()
        return _threads_after_fork(self.tracing) == len(proc.threads(os.getpid()))


class _State:
    """What can be seen of an import beside its modules."""

    def __init__(self, output: int) -> None:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError, AttributeError):
                stream.flush()
        self.threads = proc.threads(os.getpid())
        self._facts = (
            os.fstat(output).st_size,
            os.listdir("/proc/self/fd"),
            dict(os.environ._data),  # type: ignore[attr-defined]  # not as if it was read
            os.getcwd(),
            [signal.getsignal(number) for number in sorted(signal.valid_signals())],
            list(sys.path),
            list(map(id, sys.meta_path)),
            list(map(id, sys.path_hooks)),
            [id(sys.stdin), id(sys.stdout), id(sys.stderr)],
            [id(sys.excepthook), id(sys.unraisablehook), id(sys.displayhook)],
            proc.children(os.getpid()),
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _State) and self._facts == other._facts

    __hash__ = None  # type: ignore[assignment]


def _threads_after_fork(library: forking.Tracing | None) -> int:
    """How many threads a forked process has."""
    theirs, ours = os.pipe()
    forker = Forker(library)
    pid = forker.fork_child()
    if pid == 0:
        forker.restore_threads()
        os.write(ours, b"%d" % len(proc.threads(os.getpid())))
        os._exit(0)
    os.close(ours)
    os.waitpid(pid, 0)
    with open(theirs, "rb") as answer:
        return int(answer.read() or 0)


def _captured_output() -> int:
    """Standard output and error go to a file in memory from now on; its descriptor."""
    file = os.memfd_create("launcher-output", os.MFD_CLOEXEC)
    for number in (1, 2):
        os.dup2(file, number)
    os.close(file)
    return 2


def _load_ros() -> None:
    for name in _ROS_MODULES:
        importlib.import_module(name)
    sys.modules[_ROS].get_rmw_implementation_identifier()  # loads the middleware
    _load_types(_TYPES_OF_NODES)


def _load_types(types: Sequence[tuple[str, str]]) -> None:
    check = sys.modules["rclpy.type_support"].check_for_type_support
    for module, name in types:
        if module.rpartition(".")[2] in _INTERFACES:
            with contextlib.suppress(Exception):
                check(getattr(importlib.import_module(module), name))


def _find_files() -> None:
    """Let `inspect` note the file of each module, as it does at the first message of rclpy's log.

    It resolves thousands of paths: 9 ms of a node. With a lazy module each program does it itself.
    """
    import inspect  # with rclpy it is there; without, a program may have its own `token` or `ast`

    if not any(map(is_lazy, sys.modules.values())):
        inspect.getmodule(sys._getframe())


def is_lazy(module: object) -> bool:
    """Whether a look at it loads it, as with `importlib.util.LazyLoader`, whatever that does."""
    kind = type(module)  # perhaps not of a module: `typing.io` is a class
    return issubclass(kind, ModuleType) and kind.__getattribute__ != ModuleType.__getattribute__


@contextlib.contextmanager
def _recorded_variables(names: set[str]) -> Iterator[None]:
    """Note which variables of the environment are read meanwhile."""
    environ: Any = type(os.environ)
    read = environ.__getitem__

    def note(self: object, key: object) -> Any:
        names.add(os.fsdecode(key) if isinstance(key, bytes) else str(key))
        return read(self, key)

    environ.__getitem__ = note
    try:
        yield
    finally:
        environ.__getitem__ = read


class Scan:
    """Finds the imports of programs in a separate process, while this one imports modules.

    Begins at once. `programs` have `script` or `module`, and `folder`, first in their path.
    """

    def __init__(self, programs: Sequence[Mapping[str, str]]) -> None:
        self._answer, ours = os.pipe()
        self._pid = os.fork()
        if self._pid == 0:
            try:
                os.write(ours, strict_json.packed(_found(programs)).encode())
            finally:
                os._exit(0)
        os.close(ours)

    def result(self) -> Found:
        """(modules that are imported, (module, name) of what is taken from them); once."""
        with open(self._answer, "rb") as answer:
            text = answer.read()
        os.waitpid(self._pid, 0)
        modules, attributes = strict_json.unpacked(text) if text else ([], [])
        return modules, [(module, name) for module, name in attributes]


def _found(programs: Sequence[Mapping[str, str]]) -> Found:
    from launcher.packages.imports import imports_of_all

    modules: dict[str, None] = {}
    attributes: dict[tuple[str, str], None] = {}
    for folder in dict.fromkeys(program["folder"] for program in programs):
        here = [(one["script"], one["module"]) for one in programs if one["folder"] == folder]
        found = imports_of_all(here, path=[folder, *sys.path] if folder else None)
        modules.update(found.installed)
        attributes.update(found.attributes)
    return list(modules), list(attributes)
