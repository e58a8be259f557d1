"""What words of other programs mean here, and misspelt ones. Only mistakes need it.

A word that asks something (`status`) is in the tables so that it, and what is near it, is not taken
for a verb that does something (`start`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from launcher.base.text import suggest

TARGET, REST = "TARGET", "..."  # the word behind it, and all words behind it

# In the place of a verb: the command lines that are meant.
SYNONYMS = {
    **dict.fromkeys(("status", "stat", "state", "list", "ls", "processes", "jobs"), ("ps",)),
    "version": ("--version",),
    **dict.fromkeys(("usage", "commands", "verbs"), ("--help",)),
    **dict.fromkeys(("up", "open"), (TARGET,)),
    **dict.fromkeys(("down", "shutdown", "exit", "end", "terminate", "abort"), ("quit",)),
    **dict.fromkeys(("log", "output", "journal"), ("logs",)),
    **dict.fromkeys(("tail", "follow"), ("logs -f",)),
    **dict.fromkeys(("dry-run", "preview", "explain", "validate"), (f"plan {TARGET}",)),
    "check": (f"plan {TARGET}", "doctor"),
    "diagnose": ("doctor",),
    "arguments": (f"args {TARGET}",),
    "exec": ("run",),
    "record": ("bag record",),
    **dict.fromkeys(("play", "replay"), ("bag play",)),
    "rosbag": ("bag",),
    "echo": ("topic echo",),
    "hz": ("topic hz",),
    "pub": ("topic pub",),
    "call": ("service call",),
    "topics": ("topic list",),
    "nodes": ("node list",),
    **dict.fromkeys(("params", "parameters"), ("param list",)),
    "services": ("service list",),
    "actions": ("action list",),
    **dict.fromkeys(("interfaces", "msg", "srv"), ("interface list",)),
    "packages": ("pkg list",),
    **dict.fromkeys(("create", "new", "init"), ("pkg create",)),
    **dict.fromkeys(("compile", "make", "colcon"), ("build",)),
    **dict.fromkeys(("tests", "pytest"), ("test",)),
    **dict.fromkeys(("deploy", "sync"), ("hosts sync",)),
    **dict.fromkeys(("suspend", "freeze"), ("pause",)),
    **dict.fromkeys(("continue", "unpause"), ("resume",)),
    "signal": ("kill -s SIGNAL",),
    **dict.fromkeys(("reboot", "bounce"), ("restart",)),
    "refresh": ("reload",),
    **{
        engine: (f"export {engine} {TARGET}",)
        for engine in ("systemd", "kubernetes", "compose", "podman")
    },
    "docker": (f"export compose {TARGET}",),
    **dict.fromkeys(("dashboard", "gui", "ui", "browser"), ("web",)),
    **dict.fromkeys(("tree", "rqt", "rqt_graph"), ("graph",)),
    "tf2_echo": ("tf echo",),
    **dict.fromkeys(("view_frames", "frames", "tf2"), ("tf tree",)),
    "tf2_monitor": ("tf monitor",),
    "static_transform_publisher": ("tf static",),
    **dict.fromkeys(("profile", "timing"), ("analyze",)),
    **dict.fromkeys(("backtrace", "traceback", "threads"), ("stack",)),
    **dict.fromkeys(("ros2", "launcher"), (REST,)),
}

# In the place of a verb's own verb: those that may be meant, the first one that there is.
_BELOW = {
    "ls": ("list",),
    **dict.fromkeys(("show", "describe"), ("info", "get", "list")),
    **dict.fromkeys(("status", "stat", "state"), ("info", "get", "check", "list")),
    **dict.fromkeys(("new", "init", "add"), ("create",)),
    "publish": ("pub",),
    **dict.fromkeys(("print", "cat", "read", "subscribe"), ("echo", "get")),
    **dict.fromkeys(("rm", "remove", "unset"), ("delete",)),
    "replay": ("play",),
    "save": ("record", "dump"),
    **dict.fromkeys(("verify", "validate", "test"), ("check",)),
    **dict.fromkeys(("rate", "frequency"), ("hz",)),
    "bandwidth": ("bw",),
    "goal": ("send_goal",),
    "deploy": ("sync",),
}

# Of all commands: options, and what is meant.
_OPTIONS = (
    (("--version",), "`PROGRAM --version` prints the version"),
    (
        ("--no-color", "--no-colour", "--nocolor", "--monochrome"),
        "NO_COLOR=1 in front of the command switches colours off",
    ),
    (
        ("--color", "--colour"),
        "FORCE_COLOR=1 in front of the command colours output into a pipe, NO_COLOR=1 none",
    ),
)
# The same option of a command by another name.
_OTHER_NAMES = {
    "--tail": "--lines",
    "--interval": "--period",
    "--duration": "--for",
    "--level": "--log-level",
    "--jobs": "--parallel-workers",
    "--repair": "--fix",
}
_LEAST = 5  # letters of a word that may be misspelt; too much is near a shorter one
_LIKENESS = 0.8  # of options, without their dashes


def meant_lines(word: str, verbs: Collection[str]) -> tuple[str, ...]:
    """The command lines that a word in the place of a verb may mean, by its sense or its spelling.

    They begin with one of the verbs, except those of SYNONYMS that need none.
    """
    near = [one for one in SYNONYMS if len(one) >= _LEAST and SYNONYMS[one] != (REST,)]
    known = word if word in SYNONYMS else suggest(word, [*verbs, *near])
    if known is None:  # as near to both: a verb, unless the other word asks something
        known = suggest(word, [*verbs, *(one for one in near if SYNONYMS[one] == ("ps",))])
    if known is None or known in verbs:
        return () if known is None else (known,)
    return tuple(
        line
        for line in SYNONYMS[known]
        if line in (TARGET, REST) or line[0] == "-" or line.split()[0] in verbs
    )


def meant_verb(word: str, verbs: Collection[str]) -> str | None:
    """`did you mean 'ps'?` where only a verb can be meant; None."""
    lines = [line for line in meant_lines(word, verbs) if line.split()[0] in verbs]
    return f"did you mean '{lines[0]}'?" if lines else None


def meant_below(word: str, names: Collection[str]) -> str | None:
    """The same for a verb's own verb."""
    known = suggest(word, [*names, *_BELOW])
    name = next((one for one in (known, *_BELOW.get(known or "", ())) if one in names), None)
    return name and f"did you mean '{name}'?"


def meant_option(
    flag: str, flags: Iterable[str], more: Sequence[tuple[tuple[str, ...], str]] = ()
) -> str | None:
    """What an unknown option means elsewhere, `more` included, or `did you mean '--debug'?`."""
    for given, text in (*more, *_OPTIONS):
        if flag in given:
            from launcher.base.program import program

            return text.replace("PROGRAM", program())
    flags = tuple(flags)
    other = _OTHER_NAMES.get(flag)
    near = other if other in flags else _near_option(flag, flags)
    return near and f"did you mean '{near}'?"


def _near_option(flag: str, flags: Iterable[str]) -> str | None:
    """The option that is misspelt, or begun; not its opposite, nor one that shares a word with it.

    Dashes and `no-` make different options alike, so they do not count.
    """
    stem = flag.lstrip("-").replace("_", "-")
    known = {one[2:]: one for one in flags if one.startswith("--")}
    if not flag.startswith("--"):
        return known.get(stem) if len(stem) > 1 else None
    if not stem.startswith("no"):
        known = {name: one for name, one in known.items() if not name.startswith("no-")}
    elif stem.startswith("no-"):
        known = {name[3:]: one for name, one in known.items() if name.startswith("no-")}
        stem = stem[3:]
    begun = [one for name, one in known.items() if name.startswith(stem)]
    if len(stem) > 2 and len(begun) == 1:
        return begun[0]
    near = suggest(stem, known, _LIKENESS)
    return known[near] if near else None
