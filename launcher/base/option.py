"""An option or argument of a command, and functions that read the values of many.

Tables of options name functions of modules that are imported only when a value is read: `lazy`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from launcher.base.model.record import Record

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class Option(Record):
    """An option; without `flags`, a positional argument. `option` makes one.

    An argument whose `metavar` is `PARAMETER VALUE` takes two words at a time.

    The parsed value becomes the attribute `name`. An option without a `metavar` is a flag, which
    sets `value`, or what that returns if it is a function. `read` turns a word into the value; it
    raises LauncherError, or ValueError with a message for the user.

    `count` is the number of words of its value: `1`, `?` (one or none), `*`, `+`; `=` for an
    option whose value may be left out, and must follow a `=`; for the last argument of a command
    `...`, all words that follow, whatever they look like, or `text`, the same without `--options`.
    An option that is given `repeat`edly keeps its `last` value, collects `all` of them, or may be
    given `once`. `kind` is what the control protocol expects: flag, text, count, seconds, signal.
    """

    name: str
    spelling: str
    flags: tuple[str, ...]
    metavar: str
    count: str
    help: str = ""
    read: Callable[[str], Any] = str
    default: object = None
    value: object = True
    choices: tuple[str, ...] = ()
    repeat: str = "last"
    kind: str = "text"

    @property
    def is_flag(self) -> bool:
        return bool(self.flags) and not self.metavar and self.count != "="


def option(
    spelling: str,
    help: str = "",
    read: Callable[[str], Any] = str,
    default: object = None,
    *,
    name: str = "",
    count: str = "",
    **more: Any,
) -> Option:
    """An option or argument by its spelling in help: `-n, --lines N`, `--tag[=NAME]`, `[NAME ...]`.

    The word behind `--clock [HZ]` is its value if it can be read as one, otherwise it is `value`.

    The name is that of the last flag, or the argument in lower case.
    """
    flags = tuple(
        word.partition("[=")[0].rstrip(",") for word in spelling.split() if word[0] == "-"
    )
    shape = spelling.rpartition(flags[-1])[2].lstrip() if flags else spelling
    if flags and shape.startswith("[="):
        count, shape = "=", shape[2:-1]
    elif shape.startswith("["):
        count = count or ("*" if shape.endswith(" ...]") else "?")
        shape = shape[1:-1]
    metavar = shape.removesuffix(" ...")
    count = count or ("1" if metavar == shape else "+")
    name = name or (flags[-1].lstrip("-").replace("-", "_") if flags else metavar.lower())
    if flags and not metavar and count == "1":
        more.setdefault("kind", "flag")
        default = False if default is None else default
    return Option(
        name=name,
        spelling=spelling,
        flags=flags,
        metavar=metavar,
        count=count,
        help=help,
        read=read,
        default=default,
        **more,
    )


HELP = option("-h, --help", "show this help")


DEBUG = option("--debug", "show the traceback of an error")


# What such options print is in posix/json_output.py.
JSON = option("--json", "print one JSON object")
JSON_LINES = option("--json", "print one JSON object per line")


# Of every command of a shell, and in front of it. `cli.workspace_option` takes it out.
WORKSPACE = option(
    "--workspace DIR", "the colcon workspace, instead of that around the working directory"
)


# ---- values


def number(text: str) -> float:
    """A number; ValueError."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"'{text}' is not a number") from None


def seconds(text: str) -> float:
    """A number of seconds, finite and not negative; ValueError."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not 0.0 <= value < float("inf"):
        why = ": it is below 0" if value < 0.0 else ""
        raise ValueError(f"'{text}' is not a number of seconds{why}")
    return value


def positive_seconds(text: str) -> float:
    """As `seconds`, but not 0; ValueError."""
    value = seconds(text)
    if not value:
        raise ValueError(f"'{text}' is not a number of seconds above 0")
    return value


def count(text: str, least: int = 0, most: int | None = None) -> int:
    """A whole number within limits; ValueError."""
    value = int(text) if text.isascii() and text.isdigit() and len(text) < 20 else -1
    if value < least or (most is not None and value > most):
        limits = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise ValueError(f"'{text}' is not a whole number {limits}")
    return value


def load(path: str) -> Any:
    """The object that `module:name` stands for; its module is imported now."""
    module, _, name = path.partition(":")
    __import__(module)
    return getattr(sys.modules[module], name)


def lazy(path: str, **more: object) -> Callable[..., Any]:
    """A function that calls the one that `module:name` stands for, with `more` arguments."""
    return lambda *values: load(path)(*values, **more)
