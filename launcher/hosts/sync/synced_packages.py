"""What is brought to hosts: the launcher, and the packages that it finds here."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Mapping, Sequence

from launcher.base.errors import UsageError
from launcher.base.text import did_you_mean
from launcher.hosts.sync import local_packages
from launcher.hosts.sync.release_tree import Tree, TreeEntry
from launcher.packages import overlay, source_packages, unbuilt
from launcher.packages.environment import packages, underlays
from launcher.packages.source_packages import MARKERS
from launcher.packages.workspace import MARKER, Workspace

_LAUNCHER = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
_MODULES = "lib/python/site-packages"  # of packages that are brought from their sources
_COLCON = "share/colcon-core/packages"
_DSV = f"prepend-non-duplicate;AMENT_PREFIX_PATH;\nprepend-non-duplicate;PYTHONPATH;{_MODULES}\n"
_LIBRARIES = "prepend-non-duplicate-if-exists;LD_LIBRARY_PATH;lib\n"
# Needed for building only, or with paths of this machine that nothing reads there.
_NOT_RUN = re.compile(
    r"include/.*|share/[^/]+/cmake/.*|share/[^/]+/package\.(?:sh|bash|zsh|ps1)"
    r"|lib/python[^/]*/site-packages/(?:site\.py|.*/_\w+_s(?:\.ep\.\w+)?\.c)"
)
_SHEBANG = re.compile(rb"#!\s*/\S*/python[\d.]*(?: -[a-zA-Z]+)?\s*\n")
_LAUNCHER_SCRIPT = '#!/bin/sh\nexec "${0%/*}/python" -m launcher "$@"\n'

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import Distribution


class Brought:
    """The tree of a release, and the names of its packages."""

    def __init__(self) -> None:
        self.tree = Tree()
        self.packages: list[str] = []
        self.unbuilt: dict[str, str] = {}  # package -> source folder


def collect(workspace: Workspace | None, named: Sequence[str] = ()) -> Brought:
    """The launcher, the packages of the workspace, and those used from their source folder.

    `named` are further packages, of which only the source folder is found. UsageError.
    """
    brought = Brought()
    tree = brought.tree
    tree.add_folder("lib/launcher", _LAUNCHER, [_LAUNCHER])
    tree.add_text("bin/launcher", _LAUNCHER_SCRIPT, is_executable=True)
    tree.add_text(f"install/{MARKER}", "merged\n")
    if workspace is not None:
        for prefix in (workspace.install, *reversed(underlays(workspace))):
            if os.path.isfile(os.path.join(prefix, MARKER)):
                _add_prefix(brought, prefix, workspace)
    for name, folder in _from_sources(workspace, brought.packages, named).items():
        _add_source(brought, name, folder)
    for distribution in local_packages.from_files():
        _add_installed(brought, distribution)
    _report_unbuilt(brought, workspace, named)
    tree.check()
    return brought


# ---- built packages


def _add_prefix(brought: Brought, install: str, workspace: Workspace) -> None:
    found = Tree()
    for name, prefix in packages(install).items():
        if name in brought.packages:
            continue  # a workspace above has it, too
        brought.packages.append(name)
        root = os.path.dirname(install)
        roots = [root, workspace.root, sys.prefix, *_folders_of(prefix, name)]
        found.add_folder("", prefix, roots)
        _add_developed(found, prefix, name)
    found.entries.pop(f"/{MARKER}", None)
    for entry in found.entries.values():
        path = entry.path.lstrip("/")
        if not _NOT_RUN.fullmatch(path):
            brought.tree.add(_for_host(entry, f"install/{path}"))
    brought.tree.left_out.update(found.left_out)
    brought.tree.take_problems(found)


def _folders_of(prefix: str, name: str) -> list[str]:
    """The source folder of an installed package, which links of a build lead to."""
    manifest = os.path.realpath(os.path.join(prefix, "share", name, "package.xml"))
    return [os.path.dirname(manifest)] if os.path.isfile(manifest) else []


def _add_developed(tree: Tree, prefix: str, name: str) -> None:
    """The modules of a Python package that is installed as a link to its build folder."""
    for site in _site_folders(prefix):
        for file in os.listdir(site):
            if not file.endswith(".egg-link"):
                continue
            with open(os.path.join(site, file), encoding="utf-8") as opened:
                build = opened.readline().strip()
            if sources_of := _egg_info(build, file[: -len(".egg-link")]):
                _add_modules(tree, os.path.relpath(site, prefix), build, sources_of, name)


def _site_folders(prefix: str) -> list[str]:
    lib = os.path.join(prefix, "lib")
    names = os.listdir(lib) if os.path.isdir(lib) else []
    folders = [os.path.join(lib, one, "site-packages") for one in names if one[:6] == "python"]
    return [folder for folder in folders if os.path.isdir(folder)]


def _egg_info(build: str, name: str) -> str | None:
    path = os.path.join(build, f"{name.replace('-', '_')}.egg-info")
    return path if os.path.isdir(path) else None


def _add_modules(tree: Tree, site: str, build: str, egg_info: str, name: str) -> None:
    folder = f"/{site}/{os.path.basename(egg_info)}"
    for file in ("PKG-INFO", "entry_points.txt", "top_level.txt"):
        if os.path.isfile(path := os.path.join(egg_info, file)):
            tree.add(TreeEntry(path=f"{folder}/{file}", source=path))
    for module in _lines(os.path.join(egg_info, "top_level.txt")):
        path = os.path.join(build, module)
        real = os.path.realpath(path)
        roots = [real, build, os.path.dirname(real)]
        if os.path.isdir(path):
            tree.add_folder(f"/{site}/{module}", real, roots)
        elif os.path.isfile(f"{path}.py"):
            tree.add(TreeEntry(path=f"/{site}/{module}.py", source=os.path.realpath(f"{path}.py")))


def _lines(path: str) -> list[str]:
    try:
        with open(path, encoding="utf-8") as file:
            return [line for line in file.read().split("\n") if line.strip()]
    except OSError:
        return []


def _for_host(entry: TreeEntry, path: str) -> TreeEntry:
    """The entry at its place, without paths of this machine."""
    source = entry.source
    if source is None:
        return TreeEntry(path=path, content=entry.content, target=entry.target)
    if os.path.basename(path) == "package.dsv":
        lines = [line for line in _lines(source) if ".." not in line]
        return TreeEntry(path=path, content="".join(f"{line}\n" for line in lines).encode())
    if entry.is_executable:
        with open(source, "rb") as file:
            first = file.readline(300)
            if _SHEBANG.fullmatch(first):
                header = _python_header(path.count("/"))
                return TreeEntry(path=path, content=header + file.read(), is_executable=True)
    return TreeEntry(path=path, source=source, is_executable=entry.is_executable)


def _python_header(depth: int) -> bytes:
    """The first lines of a program of the release's Python, for the shell and for Python."""
    up = "../" * depth
    return f"#!/bin/sh\n'''exec' \"${{0%/*}}/{up}bin/python\" \"$0\" \"$@\"\n' '''\n".encode()


# ---- packages that are not built


def _from_sources(
    workspace: Workspace | None, installed: Iterable[str], named: Sequence[str]
) -> dict[str, str]:
    """Package -> source folder: in, around or below the working directory, editable, or named."""
    here = os.path.realpath(os.getcwd())
    around: dict[str, str] = {}
    for name, folder in source_packages.around():
        around.setdefault(name, folder)
    known = {**around, **source_packages.editable()}
    near = {
        name: folder
        for name, folder in known.items()
        if _is_near(os.path.realpath(folder), here, workspace) or name in source_packages.editable()
    }
    for name in named:
        if name not in known and name not in installed:
            hint = did_you_mean(name, [*known, *installed])
            raise UsageError(f"--package: '{name}' is not found", hint=hint)
        if name in known:
            near[name] = known[name]
    wanted = [*near]
    for name in wanted:
        needed = source_packages.dependencies(known[name]) & known.keys()
        wanted += sorted(needed - {*wanted})
    return {name: known[name] for name in wanted if name not in installed}


def _is_near(folder: str, here: str, workspace: Workspace | None) -> bool:
    tops = [here, *([os.path.join(workspace.root, "src")] if workspace else [])]
    is_above = here == folder or here.startswith(f"{folder}/")
    ours = os.path.realpath(os.path.dirname(_LAUNCHER))
    return is_above or folder == ours or any(folder.startswith(f"{top}/") for top in tops)


def _add_source(brought: Brought, name: str, folder: str) -> None:
    """A package as its setup.py would install it; one of CMake has to be built."""
    tree = brought.tree
    found = overlay.of(name, folder, {}).contents
    if found.problem is not None:
        tree.left_out[folder] = f"{name}: setup.py could not be read: {found.problem}"
        return
    if os.path.isfile(os.path.join(folder, "CMakeLists.txt")) and not found.scripts:
        brought.unbuilt[name] = folder
        return
    brought.packages.append(name)
    for place, file in found.files.items():
        if place[:1] not in (".", "/"):
            tree.add_file(f"install/{place}", file, [folder])
    for script, target in found.scripts.items():
        tree.add(_program(f"install/lib/{name}/{script}", target))
    for module in _top_modules(name, folder, found.scripts):
        _add_module(tree, os.path.join(found.code or folder, module), module)
    tree.add_text(f"install/{MARKERS}/{name}", "")
    tree.add_text(
        f"install/{_COLCON}/{name}", ":".join(sorted(source_packages.dependencies(folder)))
    )
    tree.add_text(f"install/share/{name}/package.dsv", _DSV)


def _add_installed(brought: Brought, distribution: Distribution) -> None:
    """A package that pip has installed from a folder or a wheel here."""
    names = [one for one in local_packages.packages_of(distribution) if one not in brought.packages]
    if not names:
        return
    tree = brought.tree
    modules = local_packages.add(tree, distribution, "install", _MODULES)
    brought.packages += names
    for name in names:
        for script, target in local_packages.programs(distribution).items():
            tree.add(_program(f"install/lib/{name}/{script}", target))
        tree.add_text(f"install/{MARKERS}/{name}", "")
        tree.add_text(f"install/{_COLCON}/{name}", "")
        text = _DSV.replace(_MODULES, modules) + _LIBRARIES
        tree.add_text(f"install/share/{name}/package.dsv", text)


def _report_unbuilt(brought: Brought, workspace: Workspace | None, named: Sequence[str]) -> None:
    """Report packages that are not built, if they were asked for or others need them."""
    needed = {*named}
    for entry in brought.tree.entries.values():
        if entry.path.startswith(f"install/{_COLCON}/"):
            needed |= {name for block in entry.blocks() for name in block.decode().split(":")}
    for name, folder in brought.unbuilt.items():
        is_of_workspace = workspace is not None and folder.startswith(f"{workspace.root}/src/")
        if name in needed or is_of_workspace:
            brought.tree.left_out[folder] = f"{name} is {unbuilt.remedy(name, folder)}"


def _program(path: str, target: str) -> TreeEntry:
    module, _, name = target.partition(":")
    text = f"import sys\n\nfrom {module} import {name.partition('.')[0]}\n\nsys.exit({name}())\n"
    content = _python_header(path.count("/")) + text.encode()
    return TreeEntry(path=path, content=content, is_executable=True)


def _top_modules(name: str, folder: str, scripts: Mapping[str, str]) -> list[str]:
    """The modules at the top of a package: of its name, its programs, and its distribution."""
    found = [name, *(target.partition(":")[0].partition(".")[0] for target in scripts.values())]
    for distribution in source_packages.distributions(name):
        found += (distribution.read_text("top_level.txt") or "").split()
    return list(dict.fromkeys(found))


def _add_module(tree: Tree, path: str, module: str) -> None:
    if os.path.isdir(path):
        tree.add_folder(f"install/{_MODULES}/{module}", path, [path])
    elif os.path.isfile(f"{path}.py"):
        tree.add_file(f"install/{_MODULES}/{module}.py", f"{path}.py", [os.path.dirname(path)])
