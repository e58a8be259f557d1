"""The words of the command line that say how to supervise."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

from launcher.errors import UsageError
from launcher.model.options import RunOptions
from launcher.model.record import replace
from launcher.model.spec import RestartMode, RestartPolicy

_RESTART_EXAMPLE = "--restart robot_2=on-failure,max=5,window=60,backoff=0.5..30"
DEFAULT_JITTER = 0.1


def parse_restart(word: str) -> tuple[str, RestartPolicy]:
    """`PATTERN=MODE[,max=N][,window=S][,backoff=A..B][,delay=S][,quiet=S]`; UsageError."""
    pattern, _, rest = word.partition("=")
    mode, *settings = rest.split(",")
    modes = {one.value: one for one in RestartMode}
    if not pattern or mode not in modes:
        raise UsageError(
            f"'{word}' is no restart policy: MODE is one of {', '.join(modes)}",
            hint=f"for example: {_RESTART_EXAMPLE}",
        )
    policy = RestartPolicy(mode=modes[mode])
    given: list[str] = []
    for setting in settings:
        policy = _with_setting(policy, setting, word)
        given.append(setting.partition("=")[0])
    twice = [name for name in given if given.count(name) > 1]
    if twice:
        raise _wrong_policy(word, f"'{twice[0]}' is given twice")
    if "delay" in given and "backoff" in given:
        raise _wrong_policy(word, "'delay' and 'backoff' both say how long it waits; give one")
    return pattern, policy


def _with_setting(policy: RestartPolicy, setting: str, word: str) -> RestartPolicy:
    name, _, text = setting.partition("=")
    try:
        return _SETTINGS[name](policy, text)
    except KeyError:
        problem = f"there is no '{name}', only {', '.join(_SETTINGS)}"
    except ValueError:
        problem = f"'{setting}' is not {_MEANT.get(name, 'a number of seconds')}"
    raise _wrong_policy(word, problem)


def _wrong_policy(word: str, problem: str) -> UsageError:
    return UsageError(f"in '{word}': {problem}", hint=f"for example: {_RESTART_EXAMPLE}")


_MEANT = {
    "max": "a whole number, 0 or more",
    "backoff": "two numbers of seconds, the second not below the first, as in 0.5..30",
}


def _backoff(policy: RestartPolicy, text: str) -> RestartPolicy:
    first, _, most = text.partition("..")
    first_s, most_s = seconds(first), seconds(most)
    if most_s < first_s:
        raise ValueError(text)
    return replace(
        policy,
        delay_s=first_s,
        backoff_max_s=most_s,
        jitter=DEFAULT_JITTER,
    )


_SETTINGS: dict[str, Callable[[RestartPolicy, str], RestartPolicy]] = {
    "max": lambda policy, text: replace(policy, max_restarts=_count(text)),
    "window": lambda policy, text: replace(policy, window_s=seconds(text)),
    "backoff": _backoff,
    "delay": lambda policy, text: replace(policy, delay_s=seconds(text)),
    "quiet": lambda policy, text: replace(policy, quiet_s=seconds(text)),
}


def _count(text: str) -> int:
    number = int(text)
    if number < 0:
        raise ValueError(text)
    return number


def seconds(text: str) -> float:
    """A number of seconds, finite and not negative; ValueError."""
    number = float(text)
    if not 0.0 <= number < float("inf"):
        raise ValueError(text)
    return number


# ---- options

HELP = """\
  --restart NAME=MODE[,max=N][,window=S][,delay=S][,backoff=A..B][,quiet=S]
                       start it again: never, on-failure, always; NAME may be a pattern
  --stop NAME=SIGNAL:S,SIGNAL:S...
                       how it is stopped, as in int:2,term:1; SIGKILL comes last
  --nice NAME=N, --cpus NAME=0,2-3, --limit NAME:nofile=256,as=1G,core=0
                       its priority, its processors, its limits (as ulimit has them)
  --stagger S          at least S seconds from one start to the next
  --max-starting N     no more than N processes are starting at the same time
  --required NAME      the run ends with this process
  --exit-when-any-dies the run ends with the first death that is not followed by a restart
  --timeout S          the run ends after S seconds
  --budget NAME:cpu=80%,memory=200M,threads=N,fds=N,for=S,action=warn|restart|stop-run
                       a limit on what a process may use, looked at once a second; stop-run
                       (or stop) ends the whole run
  --budgets FILE       the same from YAML: NAME: {memory: 200M, for: 10}; there also restart,
                       stop, nice, cpus and limit, as in their options
  --ros                a node /launcher: /diagnostics, and services that start, stop and restart
                       processes, for rqt and Foxglove
  --no-log-files       only the screen
  --no-console         no prompt and no status bar below the output
  --no-control         no socket through which other shells see and steer the run; no
                       console either"""


def take_run_options(words: Sequence[str]) -> tuple[RunOptions, list[str]]:
    """(the options in `words`, the words that are something else); UsageError."""
    options = RunOptions()
    rest: list[str] = []
    queue = deque(words)
    while queue:
        word = queue.popleft()
        name, has_value, value = word.partition("=")
        if word == "--":
            return options, [*rest, word, *queue]
        if name in _FLAGS and not has_value:
            options = _FLAGS[name](options)
        elif name in _OPTIONS:
            if not has_value:
                if not queue:
                    raise UsageError(f"{name} needs a value", hint=_line_of_help(name))
                value = queue.popleft()
            options = _OPTIONS[name](options, value)
        else:
            rest.append(word)
    if options.ros and not options.control:
        raise UsageError("--ros steers the run by its socket, so it cannot go with --no-control")
    return options, rest


def _line_of_help(name: str) -> str:
    return next(line.strip() for line in HELP.splitlines() if name in line)


def _timeout(options: RunOptions, text: str) -> RunOptions:
    try:
        return replace(options, timeout_s=seconds(text))
    except ValueError:
        raise UsageError(f"--timeout takes seconds, not '{text}'") from None


def _stagger(options: RunOptions, text: str) -> RunOptions:
    try:
        return replace(options, stagger_s=seconds(text))
    except ValueError:
        raise UsageError(f"--stagger takes seconds, not '{text}'") from None


def _max_starting(options: RunOptions, text: str) -> RunOptions:
    if not text.isascii() or not text.isdigit() or int(text) == 0:
        raise UsageError(f"--max-starting takes a number of processes, not '{text}'")
    return replace(options, max_starting=int(text))


def _budget_file(options: RunOptions, path: str) -> RunOptions:
    from launcher.commands.launch.process_options import with_file

    return with_file(options, path)


def _stop(options: RunOptions, word: str) -> RunOptions:
    from launcher.commands.launch.process_options import parse_stop

    return replace(options, stop=(*options.stop, parse_stop(word)))


def _limits(name: str) -> Callable[[RunOptions, str], RunOptions]:
    def take(options: RunOptions, word: str) -> RunOptions:
        from launcher.commands.launch import process_options

        parse = getattr(process_options, f"parse_{name}")
        return replace(options, limits=(*options.limits, parse(word)))

    return take


_FLAGS: dict[str, Callable[[RunOptions], RunOptions]] = {
    "--exit-when-any-dies": lambda options: replace(options, exit_when_any_dies=True),
    "--no-log-files": lambda options: replace(options, log_files=False),
    "--no-console": lambda options: replace(options, console=False),
    "--no-control": lambda options: replace(options, control=False),
    "--ros": lambda options: replace(options, ros=True),
}
_OPTIONS: dict[str, Callable[[RunOptions, str], RunOptions]] = {
    "--restart": lambda options, word: replace(
        options, restart=(*options.restart, parse_restart(word))
    ),
    "--stop": _stop,
    "--nice": _limits("nice"),
    "--cpus": _limits("cpus"),
    "--limit": _limits("limit"),
    "--stagger": _stagger,
    "--max-starting": _max_starting,
    "--required": lambda options, word: replace(options, required=(*options.required, word)),
    "--timeout": _timeout,
    "--budget": lambda options, word: replace(options, budgets=(*options.budgets, word)),
    "--budgets": _budget_file,
}
