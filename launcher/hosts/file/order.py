"""What a host is to run: the specification of a process, independent of the machine.

A launch file is evaluated on the operator's machine, and its command lines have paths of this
machine. In an order they are references that the host resolves (`resolution`): the executable of a
package, a file in the share folder of a package, the content of a file that exists only here.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Mapping

from launcher.base.errors import LaunchFileError
from launcher.base.model.parameter_text import file_text
from launcher.base.model.record import Record
from launcher.base.model.spec import Limits, ProcessSpec, RestartPolicy, StopPolicy
from launcher.hosts.file import references
from launcher.hosts.file.references import ExecutableReference as ExecutableReference
from launcher.hosts.file.references import Inherited as Inherited
from launcher.hosts.file.references import InterpreterReference as InterpreterReference
from launcher.hosts.file.references import Part as Part
from launcher.hosts.file.references import SentFile as SentFile
from launcher.hosts.file.references import SharedFile as SharedFile
from launcher.hosts.file.references import Word as Word
from launcher.packages.overlay import without_overlays

MAX_FILE_BYTES = 1024 * 1024  # of a file that is sent with an order
# Variables that say where software is on the operator's machine, or belong to its session.
_NAMES = """
AMENT_CURRENT_PREFIX AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH
DBUS_SESSION_BUS_ADDRESS DISPLAY HOME HOSTNAME LD_LIBRARY_PATH LOGNAME MAIL OLDPWD PATH
PKG_CONFIG_PATH PWD PYTHONHOME PYTHONPATH ROS_DISTRO ROS_ETC_DIR ROS_HOME ROS_LOG_DIR
ROS_PACKAGE_PATH ROS_PYTHON_VERSION ROS_ROOT ROS_VERSION SHELL SHLVL SSH_AUTH_SOCK SSH_CLIENT
SSH_CONNECTION SSH_TTY TERM TMPDIR USER VIRTUAL_ENV WAYLAND_DISPLAY XAUTHORITY XDG_RUNTIME_DIR
XDG_SESSION_ID _
"""
_OF_THIS_MACHINE = frozenset(_NAMES.split())
# Variables of the operator's environment that nodes elsewhere need, too.
_PASSED_ON = ("ROS_", "RMW_", "RCUTILS_", "RCL_", "FASTDDS_", "FASTRTPS_", "CYCLONEDDS_", "ZENOH_")
_SEARCH_PATHS = frozenset(["PATH", "LD_LIBRARY_PATH", "PYTHONPATH", "AMENT_PREFIX_PATH"])

Warn = Callable[[str], None]


def _ignore(text: str) -> None:
    """Discard a warning."""


class Order(Record):
    """One process for a host: what it runs, with which environment and policies.

    `environment` are the variables that the process gets besides those of the host, which may be
    secret, and `variables` more of them, whose values have references; `unset` those that it must
    not have. `files` are contents by name; in a content, each of `marks` stands for a path. `cwd`
    is a folder, or `cwd_in_share` one of a package. `number` is its place among the processes of
    the run, which decides on its colour.
    """

    name: str
    label: str
    words: tuple[Word, ...]
    environment: Mapping[str, str]
    variables: Mapping[str, Word] = {}
    unset: tuple[str, ...] = ()
    files: Mapping[str, bytes] = {}
    marks: Mapping[str, SharedFile] = {}
    cwd: str | None = None
    cwd_in_share: SharedFile | None = None
    shell: bool = False
    emulate_tty: bool = False
    merge: bool = False
    restart: RestartPolicy = RestartPolicy()
    stop: StopPolicy = StopPolicy()
    limits: Limits | None = None
    number: int = 0

    @property
    def parts(self) -> tuple[Part, ...]:
        """The parts of all words and variables."""
        words = (*self.words, *self.variables.values())
        return tuple(part for word in words for part in word)

    @property
    def executables(self) -> tuple[ExecutableReference, ...]:
        return tuple(part for part in self.parts if isinstance(part, ExecutableReference))

    @property
    def shared_files(self) -> tuple[SharedFile, ...]:
        """The files of packages that the host must have."""
        found = [part for part in self.parts if isinstance(part, SharedFile)]
        found += [*self.marks.values(), *filter(None, [self.cwd_in_share])]
        return tuple(dict.fromkeys(found))

    def __repr__(self) -> str:
        """Without values of variables and contents of files, which may be secret."""
        names = ", ".join([*self.environment, *self.variables])
        return f"Order({self.name!r}, words={self.words!r}, environment=<{names}>)"


def order_for(
    spec: ProcessSpec,
    *,
    base: Mapping[str, str],
    environment: Mapping[str, str] | None = None,
    merge: bool = False,
    warn: Warn = _ignore,
) -> Order:
    """The order for a process; `base` is the operator's environment, of which `spec.env` is a
    variant, and `environment` what the hosts file adds.

    LaunchFileError names what cannot be sent; `warn` is called with what may not work there.
    """
    writer = _OrderWriter(spec, warn)
    words = writer.words()
    variables = {**writer.variables(base), **{k: (v,) for k, v in (environment or {}).items()}}
    cwd = writer.folder()
    return Order(
        name=spec.name,
        label=spec.label,
        words=words,
        environment={
            name: text
            for name, word in variables.items()
            if (text := references.plain(word)) is not None
        },
        variables={n: word for n, word in variables.items() if references.plain(word) is None},
        unset=tuple(sorted(base.keys() - spec.env.keys() - _OF_THIS_MACHINE - variables.keys())),
        files=writer.files,
        marks=writer.marks,
        cwd=None if isinstance(cwd, SharedFile) else cwd,
        cwd_in_share=cwd if isinstance(cwd, SharedFile) else None,
        shell=spec.shell,
        emulate_tty=spec.emulate_tty,
        merge=merge,
        restart=spec.restart,
        stop=spec.stop,
        limits=spec.limits,
    )


class _OrderWriter:
    """Makes words, and collects the files that they need."""

    def __init__(self, spec: ProcessSpec, warn: Warn) -> None:
        self._spec = spec
        self._environ = spec.env
        self._pass_on = warn
        ros = spec.ros
        # Parameter files that the launcher writes: in a plan they are gone already.
        self._generated = {
            source.file: source.generated
            for source in (ros.parameters if ros else ())
            if source.file is not None and source.generated is not None
        }
        self.files: dict[str, bytes] = {}
        self.marks: dict[str, SharedFile] = {}

    def _warn(self, text: str) -> None:
        self._pass_on(f"{self._spec.place}: {self._spec.name}: {text}")

    def words(self) -> tuple[Word, ...]:
        if self._spec.shell:
            return tuple(map(self._of_shell, self._spec.argv))
        program = self._program_index()
        found: list[Word] = []
        for index, text in enumerate(self._spec.argv):
            is_params = index > 0 and self._spec.argv[index - 1] == "--params-file"
            found += self._program(text) if index == program else [self._word(text, is_params)]
        return tuple(found)

    def _of_shell(self, text: str) -> Word:
        word = references.with_references(text, self._environ)
        for part in word:
            for path in references.paths_in(part) if isinstance(part, str) else ():
                self._warn(f"the shell command has a path of this machine: {path}")
        return word

    def _program_index(self) -> int:
        """The place of the program; words before it are those of `prefix=`."""
        executable = self._spec.ros.executable if self._spec.ros else None
        name = os.path.basename(executable or "")
        names = [os.path.basename(word) for word in self._spec.argv]
        return names.index(name) if name and name in names else 0

    # ---- words

    def _program(self, text: str) -> list[Word]:
        ros = self._spec.ros
        if ros is not None and ros.package and ros.executable:
            return [(ExecutableReference(ros.package, ros.executable),)]
        if references.is_interpreter(text):
            return [(InterpreterReference(),)]
        path = self._absolute(text)
        if "/" not in text or references.is_of_system(path) or not os.path.isfile(path):
            return [(text,)]
        found = references.executable_at(path) or references.shared_at(path, self._environ)
        if found is not None:
            return [(found,)]
        folder, _, name = path.rpartition("/")
        if folder == os.path.join(sys.prefix, "bin"):
            return [(name,)]  # the host finds it in its own environment
        return self._script(path) or self._stays(text)

    def _script(self, path: str) -> list[Word] | None:
        """A script that is sent, behind its interpreter; None for other programs."""
        with open(path, "rb") as file:
            line = file.readline(512)
        words = os.fsdecode(line[2:]).split(None, 1) if line.startswith(b"#!") else []
        if not words:
            return None
        words = [word.strip() for word in words]
        if any(os.path.basename(word).startswith("python") for word in words):
            return [(InterpreterReference(),), (self._send(path),)]
        return [*((word,) for word in words), (self._send(path),)]

    def _stays(self, text: str) -> list[Word]:
        self._warn(f"the program is not sent, and must be there at the same path: {text}")
        return [(text,)]

    def _word(self, text: str, is_params: bool) -> Word:
        path = self._absolute(text) if is_params else text
        whole = self._reference(path)
        if whole is not None:
            return (whole,)
        for sign in ("file://", ":=", "="):
            before, separator, after = text.partition(sign)
            found = self._reference(after) if separator else None
            if found is not None:
                return (f"{before}{separator}", found)
        return references.with_references(text, self._environ)

    def _absolute(self, path: str) -> str:
        return os.path.join(self._spec.cwd or os.getcwd(), path) if path else path

    def _reference(self, path: str) -> Part | None:
        if references.is_interpreter(path):
            return InterpreterReference()
        if path in self._generated:
            text = file_text(self._generated[path])
            return self._send_content("params.yaml", text.encode(errors="surrogateescape"))
        if not os.path.isabs(path) or "\0" in path or not os.path.exists(path):
            return None
        found = references.shared_at(path, self._environ) or references.executable_at(path)
        if found is not None or references.is_of_system(path):
            return found
        if os.path.isfile(path):
            return self._send(path)
        if os.path.isdir(path):
            self._warn(f"the folder is not sent, and must be there at the same path: {path}")
        return None

    # ---- files

    def _send(self, path: str) -> SentFile:
        size = os.path.getsize(path)
        if size > MAX_FILE_BYTES:
            raise LaunchFileError(
                f"{self._spec.name}: the file '{path}' exists only on this machine, and has "
                f"{size / 1024**2:.1f} MiB: more than {MAX_FILE_BYTES // 1024**2} MiB are not sent",
                hint="install it with a package, and name it by its share folder",
                where=self._spec.place,
            )
        try:
            with open(path, "rb") as file:
                return self._send_content(os.path.basename(path), file.read())
        except OSError as error:
            message = f"{self._spec.name}: cannot read '{path}': {error.strerror}"
            raise LaunchFileError(message, where=self._spec.place) from None

    def _send_content(self, name: str, content: bytes) -> SentFile:
        content = self._marked(content)
        name = unused_name(name, content, self.files)
        self.files[name] = content
        return SentFile(name)

    def _marked(self, content: bytes) -> bytes:
        """The content, with a mark for each path in it that leads to a share folder."""
        if b"/share/" not in content:
            return content
        try:
            word = references.with_references(content.decode(), self._environ)
        except UnicodeDecodeError:
            return content
        return b"".join(
            part.encode() if isinstance(part, str) else self._mark(part, content)
            for part in word
            if isinstance(part, str | SharedFile)
        )

    def _mark(self, shared: SharedFile, content: bytes) -> bytes:
        for mark, known in self.marks.items():
            if known == shared and mark.encode() not in content:
                return mark.encode()
        number = len(self.marks) + 1
        while f"@share-{number}@".encode() in content or f"@share-{number}@" in self.marks:
            number += 1
        self.marks[f"@share-{number}@"] = shared
        return f"@share-{number}@".encode()

    # ---- the environment and the working directory

    def variables(self, base: Mapping[str, str]) -> dict[str, Word]:
        """What the process gets of the operator's variables, and what the launch file sets."""
        found: dict[str, Word] = {}
        for name, value in self._spec.env.items():
            if base.get(name) != value:
                word = self._changed(name, value, base.get(name, ""))
            elif name.startswith(_PASSED_ON) and name not in _OF_THIS_MACHINE:
                word = self._word(value, is_params=False)
            else:
                continue
            if word != (Inherited(name),):
                found[name] = word
        return found

    def _changed(self, name: str, value: str, before: str) -> Word:
        """A variable that the launch file has set or extended."""
        if name == "AMENT_PREFIX_PATH":
            value = without_overlays(value)
        if name in _OF_THIS_MACHINE and before and before in value:
            head, _, tail = value.partition(before)
            environ = self._environ
            return references.joined(
                [
                    *references.with_references(head, environ),
                    Inherited(name),
                    *references.with_references(tail, environ),
                ]
            )
        if name in _SEARCH_PATHS and value == without_overlays(before):
            return (Inherited(name),)
        if name in _SEARCH_PATHS:
            self._warn(f"the launch file sets {name}, whose folders may not be there")
        return self._word(value, is_params=False)

    def folder(self) -> str | SharedFile | None:
        cwd = self._spec.cwd
        if cwd is None:
            return None
        path = os.path.abspath(cwd)
        shared = references.shared_at(path, self._environ)
        if shared is not None:
            return shared
        if not references.is_of_system(f"{path}/") and path not in ("/", "/tmp"):
            self._warn(f"the working directory must be there at the same path: {path}")
        return path


def unused_name(name: str, content: bytes, taken: Mapping[str, bytes]) -> str:
    """The name, with a number if another file has it."""
    stem, dot, suffix = name.rpartition(".") if "." in name[1:] else (name, "", "")
    candidates: Iterable[str] = (f"{stem}-{n}{dot}{suffix}" for n in range(2, len(taken) + 3))
    for candidate in (name, *candidates):
        if taken.get(candidate, content) == content:
            return candidate
    raise AssertionError  # there is one more candidate than names
