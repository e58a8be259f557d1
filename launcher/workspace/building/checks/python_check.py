"""Checks Python packages: setup.py, setup.cfg and the files that they name."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator
from configparser import RawConfigParser

from launcher.base.text import did_you_mean, suggest
from launcher.packages.extras import is_installed
from launcher.packages.source_packages import MARKERS
from launcher.workspace.building.sources import Package
from launcher.workspace.building.sources.setup_file import (
    SetupFile,
    configuration,
    configuration_error,
    configured_name,
)
from launcher.workspace.building.sources.source_text import PackageText, SourceError


def check_python(package: Package) -> Iterator[SourceError]:
    """The mistakes that can be seen without running setup.py; SourceError if it cannot be read."""
    setup = SetupFile(package.file("setup.py"))
    if not setup.may_call_setup:
        yield setup.source.error("does not call setup()", hint=_call(package))
        return
    yield from _name(package, setup)
    yield from _data_files(package, setup)
    yield from _packages(package, setup)
    yield from _scripts(package, setup)
    if package.build_type == "ament_python":
        yield from _marker(package, setup)
        yield from _script_folder(package, setup)


def _call(package: Package) -> str:
    return f"write: from setuptools import setup; setup(name='{package.name}', ...)"


def _name(package: Package, setup: SetupFile) -> Iterator[SourceError]:
    if package.manifest is None:
        return
    given = setup.text("name")
    if given is not None:
        name, node = given
        if _normal(name) != _normal(package.name):
            message = f"setup.py is about '{name}', package.xml about '{package.name}'"
            hint = f"write name='{package.name}'"
            yield setup.source.warning(message, node.lineno, at=name, hint=hint)
        return
    configured = configured_name(package.file("setup.cfg"))
    if configured is not None and _normal(configured) != _normal(package.name):
        source = PackageText(package.file("setup.cfg"))
        message = f"setup.cfg is about '{configured}', package.xml about '{package.name}'"
        yield source.warning(message, *source.find(configured), hint=f"write name = {package.name}")


def _normal(name: str) -> str:
    """Names differ for setuptools only if these do."""
    return name.replace("-", "_").replace(".", "_").lower()


# ---- data_files


def _data_entries(setup: SetupFile) -> Iterator[tuple[str | None, ast.expr]]:
    """(destination, list of files) of `data_files` as far as they are written in setup.py."""
    for entry in _elements(setup.argument("data_files")):
        if isinstance(entry, ast.Tuple) and len(entry.elts) == 2:
            yield setup.value_of(entry.elts[0]), entry.elts[1]


def _data_files(package: Package, setup: SetupFile) -> Iterator[SourceError]:
    """Files in `data_files` that do not exist: setuptools stops at the first one."""
    for destination, listed in _data_entries(setup):
        for node in _elements(listed):
            file = setup.value_of(node)
            if file is None or os.path.isfile(package.file(file)):
                continue
            message = f"the file '{file}' in data_files does not exist"
            if os.path.isdir(package.file(file)):
                message = f"'{file}' in data_files is not a file"
                hint: str | None = f"it is a folder: write glob('{file.rstrip('/')}/*')"
            elif destination is not None and destination.rstrip("/").endswith(MARKERS):
                hint = f"create it, an empty file: touch {file}"
            else:
                hint = _near(package.file(os.path.dirname(file)), os.path.basename(file))
            yield setup.report(message, *setup.place(node), hint=hint)


def _elements(value: ast.expr | None) -> list[ast.expr]:
    """The elements of a list; none of what is a list only when setup.py runs."""
    return value.elts if isinstance(value, (ast.List, ast.Tuple)) else []


def _near(folder: str, name: str) -> str | None:
    try:
        return did_you_mean(name, sorted(os.listdir(folder)))
    except OSError:
        return None


def _marker(package: Package, setup: SetupFile) -> Iterator[SourceError]:
    """The file that makes the package known to ROS, in `data_files`."""
    value = setup.argument("data_files")
    if setup.has_more or (value is not None and not isinstance(value, (ast.List, ast.Tuple))):
        return
    parser = configuration(package.file("setup.cfg"))
    if parser is not None and parser.has_section("options.data_files"):
        return
    entries = [destination for destination, _ in _data_entries(setup)]
    if None in entries or any(not isinstance(entry, ast.Tuple) for entry in _elements(value)):
        return  # some are known only when setup.py runs: `*generate()`
    if not any((entry or "").rstrip("/").endswith(MARKERS) for entry in entries):
        # Not needed by colcon, which adds a marker itself if it is missing.
        yield setup.source.warning(
            f"data_files has no entry for {MARKERS}: other builds of this package would not be "
            "found",
            (value or setup.call or ast.Pass(lineno=1)).lineno,
            hint=f"add ('{MARKERS}', ['resource/{package.name}'])",
        )


# ---- modules and programs


def _packages(package: Package, setup: SetupFile) -> Iterator[SourceError]:
    if setup.has_more or setup.argument("package_dir") is not None:
        return
    for node in _elements(setup.argument("packages")):
        name = setup.value_of(node)
        if name is None or os.path.isdir(package.file(*name.split("."))):
            continue
        folders = [entry.name for entry in os.scandir(package.folder) if entry.is_dir()]
        yield setup.report(
            f"the Python package '{name}' does not exist: there is no folder of this name",
            *setup.place(node),
            hint=did_you_mean(name, [one for one in folders if not one.startswith(".")]),
        )


def _scripts(package: Package, setup: SetupFile) -> Iterator[SourceError]:
    """Console scripts whose module or function does not exist."""
    if setup.argument("package_dir") is not None:
        return
    value = setup.argument("entry_points")
    if not isinstance(value, ast.Dict):
        return
    for key, scripts in zip(value.keys, value.values, strict=True):
        if not isinstance(key, ast.Constant) or key.value != "console_scripts":
            continue
        for node in _elements(scripts):
            text = setup.value_of(node)
            if text is not None:
                yield from _script(package, setup, node, text)


def _script(package: Package, setup: SetupFile, node: ast.expr, text: str) -> Iterator[SourceError]:
    name, equals, target = (part.strip() for part in text.partition("="))
    module, colon, function = (part.strip() for part in target.partition("[")[0].partition(":"))
    parts = module.split(".")
    if not equals or not colon:
        message = f"the console script '{text}' must have the form NAME = MODULE:FUNCTION"
        hint = f"write '{_script_meant(package, text)}'"
        # setuptools refuses only a missing '=': without a function the program fails.
        report = setup.source.warning if equals else setup.report
        yield report(message, *setup.place(node), hint=hint)
        return
    if not any(map(os.path.exists, (package.file(parts[0]), package.file(f"{parts[0]}.py")))):
        if not _is_elsewhere(package, setup, parts[0]):
            yield setup.source.warning(
                f"the module '{module}' of the console script '{name}' does not exist",
                *setup.place(node),
                hint=did_you_mean(parts[0], _python_packages(package)),
            )
        return
    path = package.file(*parts)
    file = f"{path}.py" if os.path.isfile(f"{path}.py") else os.path.join(path, "__init__.py")
    if not os.path.isfile(file):
        modules = _modules(os.path.dirname(path))
        yield setup.source.warning(
            f"the module '{module}' of the console script '{name}' does not exist",
            *setup.place(node),
            hint=did_you_mean(parts[-1], modules),
        )
        return
    names = _names_in(file)
    if names is not None and function.partition(".")[0] not in names:
        yield setup.source.warning(
            f"the module '{module}' has no function '{function}' for the console script '{name}'",
            *setup.place(node),
            hint=did_you_mean(function, sorted(names)),
        )


def _script_meant(package: Package, text: str) -> str:
    """The console script that a text without `=` or `:` stands for."""
    name, equals, target = (part.strip() for part in text.partition("="))
    if not equals and ":" in name:
        words = name.split()
        target = words[-1]
        name = words[0] if len(words) > 1 else target.partition(":")[0].rpartition(".")[2]
        return f"{name} = {target}"
    module, _, last = target.rpartition(".")
    if module and os.path.isfile(f"{package.file(*module.split('.'))}.py"):
        return f"{name} = {module}:{last}"  # the function follows a dot
    return f"{name} = {target or f'{package.name}.{name}'}:main"


def _is_elsewhere(package: Package, setup: SetupFile, name: str) -> bool:
    """Whether a module may be of another package, or in a folder that only setuptools finds."""
    parser = configuration(package.file("setup.cfg"))
    if setup.has_more or (parser is not None and parser.has_option("options", "package_dir")):
        return True
    if os.path.isdir(package.file("src")) or package.has("pyproject.toml"):
        return True
    if name == package.name:  # it may be installed, from before its folder was renamed
        return False
    return name in {one.name for one in package.dependencies} or is_installed(name)


def _python_packages(package: Package) -> list[str]:
    return sorted(
        entry.name
        for entry in os.scandir(package.folder)
        if os.path.isfile(os.path.join(entry.path, "__init__.py"))
    )


def _modules(folder: str) -> list[str]:
    try:
        return sorted(name[:-3] for name in os.listdir(folder) if name.endswith(".py"))
    except OSError:
        return []


def _names_in(file: str) -> set[str] | None:
    """The names that a module defines at its top; None if it may define others."""
    try:
        tree = ast.parse(PackageText(file).text)
    except (SourceError, SyntaxError, ValueError):
        return None
    names: set[str] = set()
    for node in tree.body:
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                names.add(node.name)
            case ast.Import(names=aliases) | ast.ImportFrom(names=aliases):
                names.update((one.asname or one.name).partition(".")[0] for one in aliases)
            case ast.Assign(targets=targets):
                names.update(one.id for one in targets if isinstance(one, ast.Name))
            case ast.AnnAssign(target=ast.Name(id=name)):
                names.add(name)
            case ast.Expr() | ast.If(test=ast.Compare(left=ast.Name(id="__name__"))):
                pass
            case _:
                return None
    return None if "*" in names else names


def _script_folder(package: Package, setup: SetupFile) -> Iterator[SourceError]:
    """setup.cfg puts programs where ROS looks for them: lib/PACKAGE, not bin."""
    if setup.argument("entry_points") is None and not setup.has_more:
        return
    path = package.file("setup.cfg")
    wanted = f"$base/lib/{package.name}"
    if not os.path.isfile(path):
        yield setup.source.warning(
            "without a setup.cfg the programs are installed in bin/, where ros2 run does not find "
            "them",
            hint=f"create setup.cfg: [develop] script_dir={wanted}, "
            f"[install] install_scripts={wanted}",
        )
        return
    source = PackageText(path)
    problem = configuration_error(path)
    parser = configuration(path)
    if problem is not None or parser is None:
        message, line = problem or ("setup.cfg cannot be read as a configuration file", None)
        yield source.error(message, line)
        return
    for section, key in (("develop", "script_dir"), ("install", "install_scripts")):
        dashed = parser.get(section, key.replace("_", "-"), fallback=None)
        value = parser.get(section, key, fallback=dashed)
        if value is None:
            near = _near_key(parser, section, key)
            yield source.warning(
                f"[{section}] has no {key}: the programs are installed in bin/, where ros2 run "
                "does not find them",
                _line_of(source, section, near) if near else None,
                at=near,
                hint=f"did you mean {key}?" if near else f"write [{section}] {key}={wanted}",
            )
        elif value.replace("${", "$").replace("}", "").rstrip("/") != wanted:
            line = _line_of(source, section, key)
            message = f"{key} must be {wanted}, so that ros2 run finds the programs"
            name = value.rpartition("/")[2] or value
            yield source.warning(message, line, at=name, hint=f"write {key}={wanted}")


def _near_key(parser: RawConfigParser, section: str, key: str) -> str | None:
    """The key of a section that is probably a misspelling of another one."""
    if not parser.has_section(section):
        return None
    return suggest(key, [one.replace("-", "_") for one in parser.options(section)])


def _line_of(source: PackageText, section: str, key: str) -> int | None:
    """The line of a key in a section; keys may be written with dashes and capitals."""
    current = ""
    for number, line in enumerate(source.lines, start=1):
        heading = re.match(r"\[([^]]+)\]", line)
        current = heading[1] if heading else current
        name = re.split("[=:]", line)[0].strip().lower().replace("-", "_")
        if current == section and name == key:
            return number
    return None
