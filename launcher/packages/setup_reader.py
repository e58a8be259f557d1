"""Prints what a Python package would install: `python setup_reader.py SOURCE`.

A separate process, since it runs the package's setup.py. setuptools is replaced by a recorder:
it need not be installed, takes long to import, and nothing is built. Each line is a kind and its
fields, separated by tabs:

    data DESTINATION FILE    an entry of data_files; FILE is absolute
    script NAME MODULE:OBJECT
    code FOLDER              where the modules are
    seen PATH                a file or folder that the result depends on
    done                     the last line
"""

from __future__ import annotations

import glob
import os
import sys
from types import ModuleType

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from typing import Any

_RECORDED = ("setuptools", "distutils")
SETUP_FILES = ("setup.py", "setup.cfg", "pyproject.toml", "package.xml")


class _Anything:
    """Stands for whatever else a setup.py imports from setuptools: commands, extensions."""

    def __init__(self, *args: object, **named: object) -> None:
        pass

    def __call__(self, *args: object, **named: object) -> _Anything:
        return self

    def __getattr__(self, name: str) -> _Anything:
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __iter__(self) -> Iterator[object]:
        return iter(())


class _SetupModule(ModuleType):
    """A module of setuptools or distutils; `setup` keeps its arguments."""

    given: dict[str, Any] = {}
    __version__ = "0"
    __path__: list[str] = []

    @staticmethod
    def setup(**named: Any) -> _Anything:
        _SetupModule.given = named
        return _Anything()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if name[0].isupper() or "command" in self.__name__:
            return type(name, (_Anything,), {})
        return lambda *args, **named: []  # find_packages and the like


class _SetupFinder:
    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> Any:
        from importlib.machinery import ModuleSpec

        if name.partition(".")[0] not in _RECORDED:
            return None
        return ModuleSpec(name, _SetupFinder, is_package=True)  # type: ignore[arg-type]

    @staticmethod
    def create_module(spec: Any) -> ModuleType:
        return _SetupModule(spec.name)

    @staticmethod
    def exec_module(module: ModuleType) -> None:
        pass


def _arguments_of_setup() -> dict[str, Any]:
    """What setup.py gives to `setup`; whatever it raises."""
    if not os.path.isfile("setup.py"):
        return {}
    import runpy

    for name in [name for name in sys.modules if name.partition(".")[0] in _RECORDED]:
        del sys.modules[name]  # a .pth file may have imported it
    sys.meta_path.insert(0, _SetupFinder)
    sys.argv = ["setup.py", "egg_info"]
    runpy.run_path("setup.py", run_name="__main__")
    return _SetupModule.given


def _configuration() -> Any:
    import configparser

    parser = configparser.ConfigParser(interpolation=None, delimiters=("=",))
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read("setup.cfg", encoding="utf-8")
    return parser


def _project() -> dict[str, Any]:
    """pyproject.toml; empty where Python has no reader for it."""
    if not os.path.isfile("pyproject.toml"):
        return {}
    import importlib

    for name in ("tomllib", "tomli", "pip._vendor.tomli"):
        try:
            reader = importlib.import_module(name)
        except ImportError:
            continue
        with open("pyproject.toml", "rb") as file:
            found: dict[str, Any] = reader.load(file)
        return found
    return {}


def _entries(data_files: Any) -> Iterator[tuple[str, str]]:
    """(destination, file) of `data_files`; a file alone goes to the prefix itself."""
    pairs = data_files.items() if hasattr(data_files, "items") else data_files or ()
    for entry in pairs:
        if isinstance(entry, (str, os.PathLike)):
            yield "", os.fspath(entry)
            continue
        folder, files = entry
        for file in files:
            yield os.fspath(folder), os.fspath(file)


def _listed(text: str) -> list[str]:
    """The words of a list in setup.cfg: separated by commas or lines."""
    words = text.split("\n") if "\n" in text else text.split(",")
    return [word.strip() for word in words if word.strip()]


def _expanded(table: Mapping[str, Iterable[str]]) -> Iterator[tuple[str, str]]:
    for folder, patterns in table.items():
        for pattern in patterns:
            for file in sorted(glob.glob(pattern, recursive=True)):
                if os.path.isfile(file):
                    yield folder, file


def _scripts(entry_points: Any) -> Iterator[str]:
    """`name = module:object` of the console scripts, whatever form they are given in."""
    if isinstance(entry_points, str):
        import configparser

        parser = configparser.ConfigParser(interpolation=None, delimiters=("=",))
        parser.optionxform = str  # type: ignore[assignment,method-assign]
        parser.read_string(entry_points)
        if parser.has_section("console_scripts"):
            yield from (f"{name} = {value}" for name, value in parser.items("console_scripts"))
        return
    found = (entry_points or {}).get("console_scripts", ())
    yield from _listed(found) if isinstance(found, str) else found


def _lines(package: str) -> Iterator[tuple[str, ...]]:
    given, configured, project = _arguments_of_setup(), _configuration(), _project()
    data = list(_entries(given.get("data_files")))
    scripts = list(_scripts(given.get("entry_points")))
    # `scripts=` go to the folder of `install_scripts`, which ament_python sets.
    data += [(f"lib/{package}", os.fspath(file)) for file in given.get("scripts") or ()]
    code = (given.get("package_dir") or {}).get("", ".")
    if configured.has_section("options.data_files"):
        table = dict(configured.items("options.data_files"))
        data += _expanded({folder: _listed(files) for folder, files in table.items()})
    if configured.has_section("options.entry_points"):
        scripts += _scripts(dict(configured.items("options.entry_points")))
    if configured.has_option("options", "package_dir"):
        pairs = (word.partition("=") for word in _listed(configured.get("options", "package_dir")))
        code = next((folder.strip() for name, _, folder in pairs if not name.strip()), code)
    tool = project.get("tool", {}).get("setuptools", {})
    data += _expanded(tool.get("data-files", {}))
    code = tool.get("package-dir", {}).get("", code)
    named = project.get("project", {}).get("scripts", {})
    scripts += [f"{name} = {value}" for name, value in named.items()]

    yield "code", os.path.abspath(code)
    for folder, file in dict.fromkeys(data):
        if not os.path.isabs(folder):
            yield "data", os.path.normpath(folder), os.path.abspath(file)
    for script in dict.fromkeys(scripts):
        name, _, target = script.partition("=")
        yield "script", name.strip(), target.partition("[")[0].strip()


def main() -> None:
    out = os.fdopen(os.dup(1), "w", encoding="utf-8", errors="surrogateescape")
    os.dup2(2, 1)  # what setup.py prints is no part of the result
    source, package = sys.argv[1:]
    sys.path[0] = source
    os.chdir(source)
    seen = dict.fromkeys(os.path.join(source, name) for name in SETUP_FILES)

    def note(event: str, args: tuple[Any, ...]) -> None:
        if event in ("open", "os.scandir", "os.listdir") and isinstance(args[0], str):
            path = os.path.normpath(os.path.join(source, args[0]))
            if path.startswith(source) and "__pycache__" not in path:
                seen[path] = None

    sys.addaudithook(note)
    lines = list(_lines(package))
    for fields in (*lines, *(("seen", path) for path in list(seen)), ("done",)):
        if not any("\t" in field or "\n" in field for field in fields):
            print(*fields, sep="\t", file=out)
    out.flush()


if __name__ == "__main__":
    main()
