"""A fresh evaluation of the launch file of a run, which then takes the place of the first one."""

from __future__ import annotations

import contextlib
import importlib
import linecache
import os
import sys
from collections.abc import Callable, Collection, Iterator, Sequence

from launcher.base.errors import LauncherError, LaunchFileError
from launcher.base.model.events import (
    ChangeState,
    Effect,
    LoadComponent,
    LogMessage,
    StartProcess,
)
from launcher.base.model.reload_changes import Known, Reload
from launcher.base.model.ros_arguments import full_node_name
from launcher.base.model.spec_diff import needs_restart
from launcher.language import frontends, launch_session
from launcher.language.interpreter import Interpreter
from launcher.language.interpreter.replay import Replay
from launcher.language.launch_session import replace_environment
from launcher.launch import mistakes
from launcher.launch.files_read import files_read, recording
from launcher.launch.launch_checks import refuse_circles
from launcher.launch.target import LaunchRequest
from launcher.launch.time_limit import limited
from launcher.packages.imports import is_installed

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import ModuleType

    from launcher.base.model.spec import ProcessSpec
    from launcher.base.model.supervision import StartRule
    from launcher.language.description import LaunchDescription

_PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class Reevaluation:
    """What a new evaluation has made: `adopt` it, or `discard` it.

    Until then the environment of this process is again that of the run.
    """

    def __init__(
        self,
        interpreter: Interpreter,
        description: LaunchDescription,
        reload: Reload,
        known: Sequence[Known],
        replay: Replay,
    ) -> None:
        self.interpreter = interpreter
        self.description = description
        self.reload = reload
        self.started = replay.started  # their next start is not one for the launch file
        self._repeated = replay.repeated
        self._known = {one.process_id: one.spec.spec for one in known}
        self._environment = dict(os.environ)

    def adopt(self, old: Interpreter) -> None:
        """Let the new interpreter have the run; files of processes that run on stay."""
        new = self.interpreter
        same = [one for one in self.reload.kept if not needs_restart(one.changes)]
        new.host.drop_files(path for one in same for path in _files(one.spec))
        new.host.take_files(
            old.host, (path for one in same for path in _files(self._known[one.process_id]))
        )
        new.succeed(old)
        old.host.close()
        replace_environment(self._environment)
        launch_session.current().sink = new.host.log
        launch_session.current().warning_sink = new.host.warn_quirk

    def discard(self) -> None:
        self.interpreter.host.close()

    @property
    def plan_effects(self) -> list[Effect]:
        """As if the run had begun with this launch file."""
        kept = [StartProcess(one.process_id, one.planned) for one in self.reload.kept]
        later = [effect for _, effects in self.reload.after for effect in effects]
        return [*kept, *self._repeated, *self.reload.effects, *later]


def evaluate(
    request: LaunchRequest,
    old: Interpreter,
    known: Sequence[Known],
    *,
    effects: Sequence[Effect],
    rules: Sequence[StartRule],
    adapt: Callable[[ProcessSpec], ProcessSpec],
    elapsed_s: float,
) -> Reevaluation:
    """Evaluate the launch file as it is now, with the same arguments; LauncherError.

    `effects` are those of the run so far, `rules` those of the supervision files.
    """
    with recording(), _as_at_first(), limited(request.time_limit, request.path):
        description = frontends.load(request.path)
        new = Interpreter(
            description,
            path=request.path,
            arguments=request.arguments,
            environment=launch_session.current().environment,
            noninteractive=old.context.noninteractive,
        )
        new.host.succeed(old.host)
        if rules or old.host.scopes is not None:
            new.note_scopes()
        try:
            replay = _replay(new, known, effects, adapt, old.host.numbered)
            reload = replay.run(elapsed_s)
            evaluation = Reevaluation(new, description, reload, known, replay)
            _check(evaluation, request, rules)
        except LaunchFileError as fault:
            new.host.close()
            errors = mistakes.of_launch_file(
                fault, description, new.context, request.arguments, os.environ
            )
            error = mistakes.together(errors, fault)
            raise error from error.__cause__
        except LauncherError:
            new.host.close()
            raise
    return evaluation


def _replay(
    new: Interpreter,
    known: Sequence[Known],
    effects: Sequence[Effect],
    adapt: Callable[[ProcessSpec], ProcessSpec],
    numbered: int,
) -> Replay:
    return Replay(
        new,
        known,
        done=[one.request for one in effects if isinstance(one, (LoadComponent, ChangeState))],
        said={one for one in effects if isinstance(one, LogMessage)},
        adapt=adapt,
        numbered=numbered,
    )


def _check(evaluation: Reevaluation, request: LaunchRequest, rules: Sequence[StartRule]) -> None:
    """LauncherError for arguments that nothing uses, and processes that wait for each other."""
    if evaluation.interpreter.unused_arguments and not request.lenient:
        from launcher.launch import launch_checks

        errors, _ = launch_checks.unknown_arguments(evaluation.interpreter, evaluation.description)
        if errors:
            raise mistakes.together(errors)
    if rules:
        refuse_circles(rules, evaluation.plan_effects)


def _files(spec: ProcessSpec) -> list[str]:
    sources = () if spec.ros is None else spec.ros.parameters
    return [one.file for one in sources if one.file is not None and one.generated is not None]


@contextlib.contextmanager
def _as_at_first() -> Iterator[None]:
    """Within, the environment is that of the call, and modules of the user are imported again."""
    linecache.checkcache()
    current = launch_session.current()
    sinks = current.sink, current.warning_sink
    environment = dict(os.environ)
    modules = _forget_modules(current.modules)
    current.sink = current.warning_sink = None
    replace_environment(current.environment)
    try:
        yield
    except BaseException:
        sys.modules.update(modules)
        current.pending.clear()
        current.pending_warnings.clear()
        raise
    finally:
        replace_environment(environment)
        current.sink, current.warning_sink = sinks


def _forget_modules(older: Collection[str]) -> dict[str, ModuleType]:
    """Forget what the launch file has imported of the user's own; what was forgotten."""
    importlib.invalidate_caches()
    forgotten = {}
    for name, module in list(sys.modules.items()):
        if name not in older and is_own(getattr(module, "__file__", None)):
            forgotten[name] = sys.modules.pop(name)
    return forgotten


def is_own(path: str | None) -> bool:
    """Whether this is a source file of the user: not one that is installed, or ours."""
    if path is None or not path.endswith(".py") or not os.path.isabs(path):
        return False
    return not path.startswith(_PACKAGE + os.sep) and not is_installed(path)


def is_steered(spec: ProcessSpec, effects: Sequence[Effect]) -> bool:
    """Whether one of these is a request to its node."""
    targets = {one.request.container for one in effects if isinstance(one, LoadComponent)}
    targets |= {one.request.node for one in effects if isinstance(one, ChangeState)}
    name = full_node_name(spec.argv)
    return name is not None and any(f"/{target.lstrip('/')}" == name for target in targets)


def launch_files(request: LaunchRequest, interpreter: Interpreter) -> list[str]:
    """The launch file, those that it has included, its own modules, and what it has read."""
    modules = [
        getattr(module, "__file__", None)
        for name, module in list(sys.modules.items())
        if name not in launch_session.current().modules
    ]
    paths = [request.path, *interpreter.context._includers, *filter(is_own, modules), *files_read()]
    return list(dict.fromkeys(os.path.abspath(path) for path in paths if path is not None))
