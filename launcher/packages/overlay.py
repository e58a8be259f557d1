"""A prefix of links for a package that is used from its source folder.

As `colcon build --symlink-install` does it: what setup.py would install (`data_files`, scripts) is
linked from where it would be. With the prefix in `AMENT_PREFIX_PATH`, programs find the package,
too. Prefixes are in the temporary directory, since a plan writes nowhere else. One is never
changed: if setup.py or the files that it finds have changed, there is a new one.
"""

from __future__ import annotations

import contextlib
import os
import stat
import sys
import zlib
from collections.abc import Iterable, Mapping, Sequence

from launcher.packages import source_packages
from launcher.packages.setup_reader import SETUP_FILES
from launcher.packages.source_packages import MARKERS, OVERLAY_FOLDER

_READER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "setup_reader.py")
_READER_TIMEOUT_S = 10.0
_MAX_SHEBANG = 127  # bytes; a longer line is cut off by older kernels
_PRIVATE = 0o700

_hung: dict[str, list[int]] = {}  # source folder -> stamps of its SETUP_FILES


class PackageContents:
    """What a package would install, as `setup_reader` prints it; `problem` if that failed."""

    def __init__(self, lines: Iterable[str], problem: str | None = None) -> None:
        self.problem = problem
        self.code = ""  # the folder of its modules; empty if setup.py was not read
        self.files: dict[str, str] = {}  # of `data_files`: place below the prefix -> source file
        self.scripts: dict[str, str] = {}  # name -> `MODULE:OBJECT` of its console scripts
        for line in lines:
            kind, *fields = line.split("\t")
            if kind == "data":
                place = os.path.normpath(os.path.join(fields[0], os.path.basename(fields[1])))
                self.files[place] = fields[1]
            elif kind == "script":
                self.scripts[fields[0]] = fields[1]
            elif kind == "code":
                self.code = fields[0]


class Overlay:
    """The prefix of a package, and its share folder.

    `share` is the source folder itself if every file is there where it would be in share.
    """

    def __init__(self, name: str, source: str, contents: PackageContents, prefix: str) -> None:
        self.name = name
        self.source = source
        self.prefix = prefix
        self.contents = contents
        self.share = source if _serves(name, source, contents) else f"{prefix}/share/{name}"

    def installs(self, file: str) -> bool:
        """Whether a file of the source is among those that would be installed."""
        files = self.contents.files
        return not files or any(_is_same(file, source) for source in files.values())


def _is_same(one: str, other: str) -> bool:
    with contextlib.suppress(OSError):
        return os.path.samefile(one, other)
    return False


def of(name: str, source: str, scripts: Mapping[str, str]) -> Overlay:
    """The overlay of a package; `scripts` are those of its programs that pip has installed."""
    folder = _own_folder()
    contents = _contents(name, source, folder)
    links, programs = _layout(name, source, contents, scripts)
    layout = repr((sys.executable, source, sorted(links.items()), sorted(programs.items())))
    prefix = f"{folder}/{name}-{_digest(layout)}"
    if not _is_whole(prefix, (*links, *programs)):
        _write(prefix, links, programs)
    return Overlay(name, source, contents, prefix)


def script(package: str, name: str, target: str) -> str:
    """The path of a program that calls `MODULE:OBJECT` of an installed package."""
    text = _program(target)
    digest = _digest(repr((name, text)))
    prefix, place = f"{_own_folder()}/{package}-{digest}", f"lib/{package}/{name}"
    if not _is_whole(prefix, (place,)):
        _write(prefix, {}, {place: text})
    return f"{prefix}/{place}"


def announce(prefix: str) -> None:
    """Add the prefix to `AMENT_PREFIX_PATH`, for ament_index_python and for child processes."""
    value = os.environ.get("AMENT_PREFIX_PATH", "")
    entries = [entry for entry in value.split(os.pathsep) if entry]
    if prefix not in entries:
        os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join([*entries, prefix])


def without_overlays(value: str) -> str:
    """A value of `AMENT_PREFIX_PATH` without the prefixes that were added to it here."""
    entries = value.split(os.pathsep)
    return os.pathsep.join(entry for entry in entries if OVERLAY_FOLDER not in entry)


# ---- what would be installed


def _contents(name: str, source: str, folder: str) -> PackageContents:
    """What setup.py says, from the last time if nothing that it has looked at has changed."""
    known = f"{folder}/{name}-{_digest(repr((sys.executable, source)))}.txt"
    lines = _still_valid(known)
    if lines is not None:
        return PackageContents(lines)
    if not any(os.path.isfile(os.path.join(source, name)) for name in SETUP_FILES[:3]):
        return PackageContents(())  # a package of CMake: only its build shows what it installs
    output, problem = _read_setup(name, source)
    if problem is not None:
        return PackageContents((), problem)
    lines = output.splitlines()
    stamps = [f"stamp\t{_stamp(line[5:])}\t{line[5:]}" for line in lines if line[:5] == "seen\t"]
    temporary = f"{known}.{os.getpid()}"
    with open(temporary, "w", encoding="utf-8", errors="surrogateescape") as file:
        file.write("\n".join([*stamps, *lines]))
    os.replace(temporary, known)
    return PackageContents(lines)


def _still_valid(path: str) -> list[str] | None:
    try:
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            lines = file.read().split("\n")
    except OSError:
        return None
    stamps = [line.split("\t") for line in lines if line[:6] == "stamp\t"]
    is_valid = lines[-1] == "done" and all(str(_stamp(path)) == was for _, was, path in stamps)
    return lines if is_valid else None


def _stamp(path: str) -> int:
    """When a file, or the list of names in a folder, was last changed; 0 if it is not there."""
    try:
        return os.stat(path).st_mtime_ns
    except OSError:
        return 0


def _read_setup(name: str, source: str) -> tuple[str, str | None]:
    """(output of the reader, None), or what went wrong; a setup.py that hangs is run once."""
    import subprocess

    hung = f"it did not end within {_READER_TIMEOUT_S:g} s"
    stamps = [_stamp(os.path.join(source, file)) for file in SETUP_FILES]
    if _hung.get(source) == stamps:
        return "", hung
    try:
        return _run_reader(name, source)
    except subprocess.TimeoutExpired:
        _hung[source] = stamps
        print(
            f"warning: {source}/setup.py could not be read: {hung}\n"
            "hint: the source folder is taken for the share folder; "
            "setup.py has to end by itself, without input",
            file=sys.stderr,
        )
        return "", hung


def _run_reader(name: str, source: str) -> tuple[str, str | None]:
    import subprocess

    command = [sys.executable, "-B", _READER, source, name]
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            env={**os.environ, "PYTHON_COLORS": "0"},
            timeout=_READER_TIMEOUT_S,
            check=False,
        )
    except OSError as error:
        return "", str(error)
    output = done.stdout.decode(errors="surrogateescape")
    if done.returncode == 0 and output.endswith("done\n"):
        return output, None
    said = done.stderr.decode(errors="replace").strip()
    return "", _last_error(said) if said else f"exit code {done.returncode}"


def _last_error(traceback: str) -> str:
    """The error with its line in setup.py."""
    import re

    lines = re.findall(r'File "(?:.*/)?setup\.py", line (\d+)', traceback)
    error = traceback.splitlines()[-1]
    return f"{error} (line {lines[-1]})" if lines else error


def _serves(name: str, source: str, contents: PackageContents) -> bool:
    """Whether the source folder has the files of share at the same places."""
    share = f"share/{name}/"
    return all(
        os.path.join(source, place[len(share) :]) == file
        for place, file in contents.files.items()
        if place.startswith(share)
    )


# ---- the prefix


def _layout(
    name: str, source: str, contents: PackageContents, scripts: Mapping[str, str]
) -> tuple[dict[str, str], dict[str, str]]:
    """(links, programs): places below the prefix -> what they point at, or their text."""
    share = f"share/{name}"
    links = {place: file for place, file in contents.files.items() if place[:1] not in (".", "/")}
    if _serves(name, source, contents):
        links = {place: file for place, file in links.items() if not place.startswith(f"{share}/")}
        links[share] = source
    files = (os.path.join(source, file) for file in reversed(SETUP_FILES))
    links.setdefault(f"{MARKERS}/{name}", next(filter(os.path.isfile, files), os.devnull))
    programs: dict[str, str] = {}
    has_programs = not contents.scripts.keys() <= scripts.keys()
    folders = _code_folders(name, source, contents) if has_programs else []  # searches the disk
    for script, target in contents.scripts.items():
        place = f"lib/{name}/{script}"
        if script in scripts:
            links[place] = scripts[script]
        else:
            programs[place] = _program(target, folders)
    return links, programs


def _code_folders(name: str, source: str, contents: PackageContents) -> list[str]:
    """Where a program that is not installed finds its modules, and those of its dependencies."""
    needed = source_packages.dependencies(source)
    near = (
        folder for other, folder in source_packages.around() if other in needed and other != name
    )
    return [contents.code or source, *near]


def _program(target: str, folders: Sequence[str] = ()) -> str:
    """The text of a script; its modules are in `folders`, or installed."""
    module, _, name = target.partition(":")
    first = name.partition(".")[0]
    interpreter = f"#!{sys.executable}\n"
    if " " in sys.executable or len(os.fsencode(interpreter)) > _MAX_SHEBANG:
        interpreter = f"#!/bin/sh\n'''exec' \"{sys.executable}\" \"$0\" \"$@\"\n' '''\n"
    paths = f"sys.path[0] = {folders[0]!r}\nsys.path += {folders[1:]!r}\n" if folders else ""
    return f"{interpreter}import sys\n\n{paths}from {module} import {first}\n\nsys.exit({name}())\n"


def _is_whole(prefix: str, places: Iterable[str]) -> bool:
    """Whether all is there: temporary directories are cleaned up file by file."""
    return all(os.path.lexists(f"{prefix}/{place}") for place in places)


def _write(prefix: str, links: Mapping[str, str], programs: Mapping[str, str]) -> None:
    for place, target in links.items():
        _put(f"{prefix}/{place}", lambda path, target=target: os.symlink(target, path))
    for place, text in programs.items():
        _put(f"{prefix}/{place}", lambda path, text=text: _write_program(path, text))


def _put(path: str, make: object) -> None:
    """Make a file beside its place, then move it there: others may use the prefix already."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    temporary = f"{path}.{os.getpid()}"
    assert callable(make)
    with contextlib.suppress(FileNotFoundError):
        os.unlink(temporary)
    make(temporary)
    os.replace(temporary, path)


def _write_program(path: str, text: str) -> None:
    with open(path, "w", encoding="utf-8", errors="surrogateescape") as file:
        file.write(text)
        os.fchmod(file.fileno(), 0o755)


def _digest(text: str) -> str:
    data = text.encode(errors="surrogateescape")
    return f"{zlib.crc32(data):08x}{zlib.adler32(data):08x}"


def _own_folder() -> str:
    """A folder below the temporary directory that nobody else can write to."""
    import tempfile

    folder = os.path.join(tempfile.gettempdir(), f"{OVERLAY_FOLDER}{os.getuid()}")
    with contextlib.suppress(FileExistsError):
        os.mkdir(folder, _PRIVATE)
    found = os.lstat(folder)
    is_own = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    if is_own and not stat.S_IMODE(found.st_mode) & 0o022:
        return folder
    return tempfile.mkdtemp(prefix=OVERLAY_FOLDER)
