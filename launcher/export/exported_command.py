"""Command lines without paths of the operator's machine."""

from __future__ import annotations

import os
from collections.abc import Iterator

from launcher.base import strict_json
from launcher.base.errors import PackageNotFoundError
from launcher.base.model.record import replace
from launcher.base.model.spec import ProcessSpec
from launcher.export.export_model import FileOf, LauncherPython, Part, Scratch, Word
from launcher.export.exported_variables import looks_secret
from launcher.export.unit_names import file_name
from launcher.hosts.file import order_json, references
from launcher.hosts.file.order import MAX_FILE_BYTES, Order, unused_name
from launcher.packages.finder import share_directory

# A terminal, or a debugger that waits for its user: nobody sees them where this will run.
_PROGRAMS = """
xterm uxterm gnome-terminal konsole xfce4-terminal terminator lxterminal rxvt urxvt screen tmux
gdb lldb pdb ddd
"""
_FOR_A_USER = frozenset(_PROGRAMS.split())
_ORDER = ".order.json"


class _NotSentError(Exception):
    """The path can only be found on the host."""


class ExportedCommand:
    """The words of an order, and the files that they need beside the exported ones.

    An order with paths that can only be found on the host is written to a file, which
    `hosts.run_order` reads there.
    `left_out` is the program of a `prefix` that nobody would see, None without one.
    """

    def __init__(self, order: Order, spec: ProcessSpec, unit: str) -> None:
        self._unit = unit
        self._environ = spec.env
        self.files: dict[str, bytes] = {}
        self.left_out, self._order = _without_prefix(order, spec)
        self.words = self._words()

    @property
    def is_order(self) -> bool:
        """Whether the environment, the working directory and the shell are in a file as well."""
        return f"{self._unit}{_ORDER}" in self.files

    @property
    def paths(self) -> list[str]:
        """Paths of this machine in the files, which are copied as they are."""
        texts = (content.decode(errors="replace") for content in self.files.values())
        return sorted({path for text in texts for path in references.paths_in(text)})

    def _words(self) -> tuple[Word, ...]:
        order = self._order
        try:
            if order.marks or order.variables or order.cwd_in_share is not None:
                raise _NotSentError
            return tuple(
                one for index, word in enumerate(order.words) for one in self._of(index, word)
            )
        except _NotSentError:
            return self._as_order()

    def _as_order(self) -> tuple[Word, ...]:
        name = f"{self._unit}{_ORDER}"
        # The environment is in the exported files, or private.
        written = {k: v for k, v in self._order.variables.items() if not looks_secret(k)}
        data = order_json.encode(replace(self._order, environment={}, variables=written))
        self.files = {name: strict_json.packed(data, sort_keys=True, indent=1).encode() + b"\n"}
        run = ("-m",), ("launcher.hosts.file.run_order",)
        return ((LauncherPython(),), *run, (FileOf(name),), (Scratch(),))

    def _of(self, index: int, word: references.Word) -> Iterator[Word]:
        whole = word[0] if len(word) == 1 else None
        if isinstance(whole, references.ExecutableReference) and index == _program(self._order):
            yield (LauncherPython(),)
            yield from (("-m",), ("launcher",), ("run",), (whole.package,), (whole.name,))
        else:
            yield tuple(map(self._part, word))

    def _part(self, part: references.Part) -> Part:
        match part:
            case str():
                return part
            case references.InterpreterReference():
                return LauncherPython()
            case references.SentFile(name=name):
                return self._keep(name, self._order.files[name])
            case references.SharedFile(package=package, path=path):
                return self._shared(package, path)
        raise _NotSentError

    def _shared(self, package: str, path: str) -> Part:
        """A copy of a file in the share folder of a package."""
        try:
            full = os.path.join(share_directory(package, self._environ), path)
            if not os.path.isfile(full) or os.path.getsize(full) > MAX_FILE_BYTES:
                raise _NotSentError
            with open(full, "rb") as file:
                return self._keep(os.path.basename(path), file.read())
        except (OSError, PackageNotFoundError):
            raise _NotSentError from None

    def _keep(self, name: str, content: bytes) -> FileOf:
        chosen = unused_name(file_name(f"{self._unit}.{name}"), content, self.files)
        self.files[chosen] = content
        return FileOf(chosen)


def _program(order: Order) -> int | None:
    """The place of the executable of a package that is started, behind the words of a prefix."""
    for index, word in enumerate(order.words):
        if isinstance(word[0], references.ExecutableReference):
            return index
    return None


def _without_prefix(order: Order, spec: ProcessSpec) -> tuple[str | None, Order]:
    first = os.path.basename(spec.argv[0])
    place = _program(order)
    if not place or first not in _FOR_A_USER:
        return None, order
    return first, replace(order, words=order.words[place:])
