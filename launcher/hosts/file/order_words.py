"""Orders as command lines, for hosts without an agent."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base import strict_json
from launcher.hosts.file import order_json
from launcher.hosts.file.hosts_model import DEFAULT_PYTHON, Host
from launcher.hosts.file.order import Order
from launcher.hosts.file.references import (
    ExecutableReference,
    Inherited,
    InterpreterReference,
    Part,
    SentFile,
    SharedFile,
    Word,
)

ORDER_FILE = "order.json"  # of an order that the host has to resolve
PYTHON = "<python>"  # stands for what `hosts sync` has made there, else the usual Python
FILES = "<files>"  # stands for the folder on the host with the files that are sent


def is_simple(order: Order) -> bool:
    """Whether `launcher run` can do it: an executable of a package, and words without paths of
    the host.
    """
    parts = [part for part in order.parts[1:] if not isinstance(part, str | SentFile)]
    first = order.words[0] if order.words else ()
    is_executable = len(first) == 1 and isinstance(first[0], ExecutableReference)
    rest = (order.shell, order.marks, order.variables, order.cwd_in_share, parts)
    return is_executable and not any(rest)


def is_plain(order: Order) -> bool:
    """Whether its words are the same on every host, but for the folder of the files."""
    first = order.words[0][0] if order.words else ""
    is_found = isinstance(first, InterpreterReference) or (
        isinstance(first, str) and first[:1] == "/"
    )
    rest = (order.shell, order.marks, order.variables, order.cwd_in_share)
    kinds = str | SentFile | InterpreterReference
    return is_found and not any(rest) and all(isinstance(part, kinds) for part in order.parts)


def as_words(order: Order, *, python: str, folder: str) -> tuple[str, ...]:
    """The command line on a host without an agent, where `files_of` are in `folder`."""
    if is_plain(order):
        return tuple(_text(word, python, folder) for word in order.words)
    if is_simple(order):
        (program,) = order.words[0]
        assert isinstance(program, ExecutableReference)
        words = (_text(word, python, folder) for word in order.words[1:])
        return (python, "-m", "launcher", "run", program.package, program.name, *words)
    return (python, "-m", "launcher.hosts.file.run_order", f"{folder}/{ORDER_FILE}")


def _text(word: Word, python: str, folder: str) -> str:
    texts = []
    for part in word:
        if isinstance(part, SentFile):
            texts.append(f"{folder}/{part.name}")
        else:
            texts.append(part if isinstance(part, str) else python)
    return "".join(texts)


def files_of(order: Order) -> Mapping[str, bytes]:
    """The files that `as_words` needs in its folder, by name."""
    if is_plain(order) or is_simple(order):
        return order.files
    return {ORDER_FILE: strict_json.packed(order_json.encode(order)).encode()}


# ---- for users


def words_there(host: Host, order: Order) -> tuple[str, ...]:
    """The command line on the host; what the host finds itself stands in `<...>`."""
    if is_simple(order):
        return as_words(order, python=_python_there(host), folder=FILES)
    words = tuple("".join(text_there(part, host) for part in word) for word in order.words)
    return ("sh", "-c", " ".join(words)) if order.shell else words


def _python_there(host: Host) -> str:
    """Which one `hosts sync` has made is known only there."""
    return PYTHON if host.python == DEFAULT_PYTHON else host.python


def text_there(part: Part, host: Host) -> str:
    match part:
        case str():
            return part
        case ExecutableReference():
            return f"<{part.package}/{part.name}>"
        case SharedFile():
            return f"<share of {part.package}>" + (f"/{part.path}" if part.path else "")
        case SentFile():
            return f"{FILES}/{part.name}"
        case InterpreterReference():
            return _python_there(host)
        case Inherited():
            return f"<{part.variable}>"


def folder_there(order: Order, host: Host) -> str | None:
    """The working directory on the host; None: the home."""
    if order.cwd_in_share is not None:
        return text_there(order.cwd_in_share, host)
    return order.cwd
