"""What the program prints without words, and with `--help`."""

from __future__ import annotations

import contextlib

from launcher.base.errors import exit_code_table
from launcher.base.program import program
from launcher.base.verb_table import INTERNAL, TASK_OF, TASKS, VERBS
from launcher.control.verb import RUNS
from launcher.control.verbs import VERBS as CONTROL
from launcher.language.frontends.locate import names_here

# The most used command lines, by the verb that says what each does.
_MOST_USED = {
    "launch": "TARGET",
    "plan": "plan TARGET",
    "ps": "ps",
    "logs": "logs NAME",
    "topic": "topic list",
}


def first_steps() -> str:
    """What the program prints without words, in twelve lines at most."""
    name, helps = program(), {**VERBS, **dict(control_verbs())}
    helps["launch"] = "run a launch file"
    widest = max(map(len, _MOST_USED.values()))
    target = next(iter(_names_here()), "TARGET")
    return "\n".join(
        [
            f"usage: {name} TARGET [name:=value ...] [options]",
            f"       {name} VERB ...",
            "",
            *(f"  {name} {line:{widest}}  {helps[verb]}" for verb, line in _MOST_USED.items()),
            "",
            f"{name} --help lists all verbs: {', '.join(TASKS)}",
            f"next: {name} {target}, then type help",
        ]
    )


def _names_here() -> list[str]:
    with contextlib.suppress(OSError):  # such as a folder that is gone
        return names_here()
    return []


def overview(*, is_whole: bool = False) -> str:
    """What `--help` prints: the verbs by task, and the exit codes; internal ones if `is_whole`."""
    name = program()
    lines = [
        f"usage: {name} TARGET [name:=value ...] [options]",
        f"       {name} VERB ...",
        f"       {name} help [VERB | --all] | -h, --help | -V, --version",
        f"       {name} --workspace DIR TARGET|VERB ...",
        "",
        "TARGET is a launch file, the name of one (`system` for launch/system.launch.py), or",
        f"PACKAGE FILE as with `ros2 launch`. {name} VERB --help lists the options of a verb.",
        "",
    ]
    helps = {**dict(control_verbs()), **VERBS}
    titles = {**TASKS, INTERNAL: INTERNAL} if is_whole else TASKS
    for task, title in titles.items():
        lines.append(f"{title}:")
        lines += [f"  {verb:9} {text}" for verb, text in helps.items() if TASK_OF[verb] == task]
        lines.append("")
    return "\n".join([*lines, *exit_code_table()])


def control_verbs() -> list[tuple[str, str]]:
    """(name, one line of help) of the verbs about a running launch."""
    return [*((verb.name, verb.help) for verb in CONTROL if verb.shell), (RUNS.name, RUNS.help)]
