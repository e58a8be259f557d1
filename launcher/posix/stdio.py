"""Standard streams: redirects output at the level of descriptors, and prints text to it safely."""

from __future__ import annotations

import contextlib
import fcntl
import os
import sys
from collections.abc import Iterator

TYPE_CHECKING = False
if TYPE_CHECKING:
    import threading
    from typing import TextIO

STDIN, STDOUT, STDERR = 0, 1, 2


@contextlib.contextmanager
def stdout_to_stderr() -> Iterator[None]:
    """Send what this process and its children print to standard error."""
    sys.stdout.flush()
    try:
        saved = os.dup(STDOUT)
    except OSError:  # closed: there is nothing to keep clean
        yield
        return
    try:
        _duplicate_stderr()
        yield
    finally:
        # What was printed meanwhile may still be in the buffer.
        sys.stdout.flush()
        os.dup2(saved, STDOUT)
        os.close(saved)


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Discard what this process and its children print."""
    sys.stderr.flush()
    saved = os.dup(STDERR)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, STDERR)
        with stdout_to_stderr():
            yield
    finally:
        sys.stderr.flush()
        os.dup2(saved, STDERR)
        os.close(saved)
        os.close(nowhere)


def keep_for_messages() -> None:
    """Move standard output to another descriptor, since it carries messages of ours.

    What libraries in C print goes to standard error from now on, and not into a message.
    """
    sys.stdout.flush()
    fd = fcntl.fcntl(STDOUT, fcntl.F_DUPFD_CLOEXEC, STDERR + 1)
    _duplicate_stderr()
    sys.stdout = open(fd, "w", encoding=sys.stdout.encoding, errors=sys.stdout.errors)  # noqa: SIM115


def end_of_input() -> threading.Event:
    """An event that is set when standard input ends; what comes before is discarded.

    A helper process ends with its input, the other end of which the launcher has.
    """
    import threading

    over = threading.Event()

    def read() -> None:
        while os.read(STDIN, 4096):  # not of sys.stdin, whose lock an exit may wait for
            pass
        over.set()

    threading.Thread(target=read, daemon=True).start()
    return over


def _duplicate_stderr() -> None:
    try:
        os.dup2(STDERR, STDOUT)
    except OSError:  # standard error is closed
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, STDOUT)
        os.close(nowhere)


def report_lost_output(error: OSError, stream: TextIO) -> None:
    """Say that output was lost, unless it was that of stderr, and discard what follows."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    if stream.fileno() == STDOUT:
        with contextlib.suppress(OSError):  # the same full disk
            print(f"error: cannot write the output: {error.strerror or error}", file=sys.stderr)


# Those of trees, cut texts, and tolerances, as wide as they are where that matters.
_SIMILAR = {"─": "-", "│": "|", "├": "|", "└": "`", "…": "~", "±": "+-"}


def replacement(error: UnicodeError) -> tuple[str | bytes, int]:
    """What is printed in place of characters that the encoding lacks, and where they end.

    Escapes are those of JSON; bytes of names that are not UTF-8 stay these bytes.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    char = error.object[error.start]
    if "\udc80" <= char <= "\udcff":
        return char.encode(errors="surrogateescape"), error.start + 1
    units = char.encode("utf-16-be", "surrogatepass").hex()
    escaped = "".join(f"\\u{units[at : at + 4]}" for at in range(0, len(units), 4))
    return _SIMILAR.get(char, escaped), error.start + 1


def can_print(text: str) -> bool:
    """Whether the encoding of standard output has all of these characters."""
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def print_text(text: str) -> None:
    """Print a text; a closed pipe (`| head`) is ignored."""
    try:
        sys.stdout.write(text + "\n")
        sys.stdout.flush()
    except BrokenPipeError:
        # The interpreter flushes once more when it ends.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, STDOUT)
        os.close(nowhere)
