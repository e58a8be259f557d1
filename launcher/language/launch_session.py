"""What a launch file uses of a run without a context: log folder, loggers, environment, runner."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping

from launcher.packages import distribution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Protocol

    from launcher.language.diagnostics.origin import FileLine
    from launcher.language.events.base import Event

    class LogSink(Protocol):
        """Takes a message; `sink` is where it goes, both if it is empty; `line` its final form."""

        def __call__(
            self, logger: str, level: str, text: str, *, sink: str = "", line: str | None = None
        ) -> None: ...

    class Formats(Protocol):
        """How the launcher's own messages are written, if the launch file sets that.

        The line, "" for the usual one, or None for none.
        """

        level: int

        def screen_line(self, level: str, logger: str, text: str) -> str | None: ...
        def file_line(self, level: str, logger: str, text: str) -> str | None: ...

    class ServiceRun(Protocol):
        """One run of a LaunchService; `post` from any thread, `close` at the end.

        `stop_signal`: the first Ctrl-C, SIGTERM and so on, which the run has taken.
        """

        @property
        def stop_signal(self) -> int | None: ...
        def post(self, event: Event) -> None: ...
        def run(self) -> int: ...
        async def run_async(self) -> int: ...
        def shut_down(self, event: Event) -> None: ...
        def close(self) -> None: ...

    class RosNode(Protocol):
        """A ROS node that is spun until `close`."""

        context: object
        node: object
        executor: object

        def close(self) -> None: ...

    Runner = Callable[[Any, bool], ServiceRun]  # of a context, and whether to end when idle


# In order; a name that is not among them is an unknown distribution.
DISTRIBUTIONS = ("humble", "iron", "jazzy", "kilted", "lyrical", "rolling")


LEVEL_NAMES = {"WARN": "WARNING", "FATAL": "CRITICAL"}  # as lines have those with two names


class LaunchSession:
    """The log folder, and where messages of loggers go: (logger, level, text).

    `environment` is that of the call: launch files change `os.environ` already while they are
    loaded. `sink` takes messages while an interpreter runs; `pending` keeps earlier
    ones for it. `warn` does the same for warnings with a place, each once. `modules` are those that
    were imported before any launch file. `reads_arguments`: the launch file has looked at the words
    of the command line itself. `target` is the distribution of ROS 2 whose behaviour is wanted, if
    not that of the installed one. `uses` is a set, in order, of the `watched` names that
    launch files use, with their places.
    """

    def __init__(self, *, is_script: bool = False) -> None:
        self.is_script = is_script
        self.formats: Formats | None = None
        self.runner: Runner | None = None
        self.open_ros_node: Callable[[list[str]], RosNode] | None = None
        self.make_log_dir: Callable[[], str | None] = lambda: None
        self.environment = dict(os.environ)
        self._installed: tuple[str | None] | None = None  # the distribution, once it is known
        self.modules = frozenset(sys.modules)
        self.reads_arguments = False
        self.log_name = "launch"  # of the launcher's own messages, and of the file with all lines
        self.is_debug = False  # --debug, which also shows messages of level DEBUG
        self.target: str | None = None
        self.watched: frozenset[str] = frozenset()
        self.uses: dict[tuple[str, FileLine], None] = {}
        self.nodes_made = 0  # by the launch file, whether they are started or not
        self._log_dir: str | None = None
        self._made_log_dir: str | None = None
        self.sink: LogSink | None = None
        self.pending: list[tuple[tuple[str, str, str], dict[str, Any]]] = []
        self.warning_sink: Callable[[str, FileLine | None], None] | None = None
        self.pending_warnings: dict[tuple[str, FileLine | None], None] = {}

    @property
    def prints(self) -> bool:
        """Whether messages are to be printed at once: a script, of which nothing runs yet."""
        return self.is_script and self.sink is None

    def log(
        self, logger: str, level: str, text: str, *, sink: str = "", line: str | None = None
    ) -> None:
        """Hand a message of a logger to the interpreter, or keep it until one runs."""
        if self.sink is None:
            self.pending.append(((logger, level, text), {"sink": sink, "line": line}))
        else:
            self.sink(logger, level, text, sink=sink, line=line)

    @property
    def level(self) -> int:
        """The least level that is logged, a number of `logging`: 20 is INFO, 10 is DEBUG."""
        usual = 10 if self.is_debug else 20
        return usual if self.formats is None else self.formats.level

    def is_like(self, distribution: str) -> bool:
        """Whether a difference that came with this distribution of ROS 2 is wanted."""
        return self.distribution in DISTRIBUTIONS[DISTRIBUTIONS.index(distribution) :]

    @property
    def distribution(self) -> str | None:
        """The target, else the installed one; every include asks for it."""
        if self.target:
            return self.target
        if self._installed is None:
            self._installed = (distribution.installed(self.environment),)
        return self._installed[0]

    def note_use(self, name: str, place: FileLine | None) -> None:
        """A launch file uses this: `$(word)`, `<tag>`, `<tag attribute>`, a name of Python."""
        if name in self.watched and place is not None:
            self.uses[name, place] = None

    def note_arguments_read(self) -> None:
        self.reads_arguments = True

    def forget_log_dir(self) -> None:
        """Make another folder for the next run, unless the script has set one."""
        self._made_log_dir = None

    def warn(self, text: str, origin: FileLine | None) -> None:
        """Hand a warning about the launch file to the interpreter, or keep it until one runs."""
        if self.warning_sink is None:
            self.pending_warnings[text, origin] = None
        else:
            self.warning_sink(text, origin)

    @property
    def log_dir(self) -> str:
        """The folder that the driver has set, else the parent folder of all runs."""
        if self._log_dir is None:
            self._made_log_dir = self._made_log_dir or self.make_log_dir()
        return self._log_dir or self._made_log_dir or default_log_dir()

    @log_dir.setter
    def log_dir(self, folder: str | None) -> None:
        self._log_dir = folder


def default_log_dir() -> str:
    """`$ROS_LOG_DIR`, else `$ROS_HOME/log`, else `~/.ros/log`."""
    folder = os.environ.get("ROS_LOG_DIR")
    if not folder:
        home = os.environ.get("ROS_HOME") or os.path.join("~", ".ros")
        folder = os.path.join(home, "log")
    return os.path.normpath(os.path.expanduser(folder))


open_sessions: list[LaunchSession] = []  # of open vocabularies, the innermost last


def current() -> LaunchSession:
    """The session of the innermost open vocabulary; a temporary one if none is open."""
    return open_sessions[-1] if open_sessions else LaunchSession(is_script=True)


# `os.environ` as it was copied last: its bytes, and its texts, which are the same objects in all
# copies: `os.environ` makes new ones each time, 10 KB.
_copied: tuple[dict[Any, Any], dict[str, str]] = ({}, {})


def copy_environment() -> dict[str, str]:
    """A copy of `os.environ`, which every scope and every process needs, and few change."""
    global _copied
    encoded = getattr(os.environ, "_data", None)  # none: a launch file has replaced it
    if encoded is None:
        return dict(os.environ)
    if encoded != _copied[0]:
        texts = {sys.intern(name): sys.intern(value) for name, value in os.environ.items()}
        _copied = (dict(encoded), texts)
    return dict(_copied[1])


def replace_environment(values: Mapping[str, str]) -> None:
    """Make `os.environ` equal to `values`, touching only what differs."""
    if values == copy_environment():
        return
    for name in [name for name in os.environ if name not in values]:
        del os.environ[name]
    for name, value in values.items():
        if os.environ.get(name) != value:
            os.environ[name] = value
