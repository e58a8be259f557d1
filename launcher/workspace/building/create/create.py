"""From what the command line asks for to packages on disk."""

from __future__ import annotations

import getpass
import os
import shlex
import subprocess
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from launcher.base.errors import UsageError
from launcher.base.program import program
from launcher.base.text import did_you_mean
from launcher.packages import source_packages
from launcher.packages.environment import environment
from launcher.packages.finder import package_names, resource_prefix, share_directory
from launcher.packages.workspace import VARIABLE
from launcher.packages.workspace import find as find_workspace
from launcher.workspace.building.create import CMAKE, PYTHON, name_rules, target_folder
from launcher.workspace.building.create.name_rules import is_email
from launcher.workspace.building.create.templates import (
    PackageMetadata,
    interface_files,
    node_files,
)
from launcher.workspace.building.sources import find as find_packages
from launcher.workspace.building.sources.source_text import shown

TO_DO = "TODO"
_INTERFACES = "rosidl_interface_packages"  # the group of packages with interfaces
UNKNOWN_EMAIL = "user@example.com"
_GIT_TIMEOUT_S = 5.0


@dataclass(frozen=True)
class Created:
    """What to print: `warnings` to stderr."""

    warnings: list[str]
    lines: list[str]


@dataclass(frozen=True, kw_only=True)
class CreateRequest:
    """The command line; None and empty where it says nothing.

    `verbs` are those of the launcher: a package of such a name is launched by `launch NAME`.
    """

    name: str
    nodes: Sequence[str] = ()
    with_interfaces: bool = False
    build_type: str | None = None
    dependencies: Sequence[str] = ()
    folder: str | None = None
    description: str | None = None
    license: str | None = None
    maintainer: str | None = None
    email: str | None = None
    verbs: Collection[str] = ()

    @property
    def with_nodes(self) -> bool:
        return bool(self.nodes) or not self.with_interfaces

    @property
    def interfaces(self) -> str | None:
        """The name of the package of interfaces."""
        if not self.with_interfaces:
            return None
        return f"{self.name}{name_rules.INTERFACES}" if self.nodes else self.name

    @property
    def packages(self) -> list[str]:
        wanted = (self.interfaces, self.name if self.with_nodes else None)
        return [name for name in wanted if name is not None]


def create(request: CreateRequest, env: Mapping[str, str]) -> Created:
    """Make the packages. UsageError before anything is written, LauncherError."""
    name_rules.check_package(request.name, partial(_is_usable, request, env))
    _check(request)
    folder = _free_folder(request, env)
    warnings = list(_check_dependencies(request, folder, env)) if request.dependencies else []
    packages = _contents(request, folder)
    target_folder.write(folder, packages)
    return Created(warnings, list(_report(request, folder, packages)))


# ---- checks


def _is_usable(request: CreateRequest, env: Mapping[str, str], name: str) -> bool:
    """Whether the packages can be made under this name."""
    try:
        name_rules.check_package(name)
        _free_folder(replace(request, name=name), env)
    except UsageError:
        return False
    return True


def _free_folder(request: CreateRequest, env: Mapping[str, str]) -> str:
    """The folder for the packages; UsageError if a package or module has one of the names."""
    folder = target_folder.destination(request.folder)
    target_folder.check_free(folder, request.packages)
    known = package_names(env)
    for name in request.packages:
        _check_unknown(name, known, env)
    return folder


def _check(request: CreateRequest) -> None:
    """UsageError if the command line alone shows that it is wrong."""
    name_rules.check_nodes(request.nodes)
    for dependency in request.dependencies:
        name_rules.check_dependency(dependency)
        if dependency in request.packages:
            raise UsageError(f"--dependencies: '{dependency}' is a package that is to be created")
    for option in ("description", "license", "maintainer"):
        if (text := getattr(request, option)) is not None:
            name_rules.check_line(f"--{option}{'-name' if option == 'maintainer' else ''}", text)
    stem = request.name.removesuffix("_msgs").removesuffix(name_rules.INTERFACES)
    if request.with_interfaces and request.nodes and stem != request.name:
        raise UsageError(
            f"'{request.name}' would be the package of the nodes, and the interfaces would be in "
            f"'{request.interfaces}'",
            hint=f"name the nodes' package, as in: pkg create {stem} --node NODE --interfaces",
        )
    if request.build_type == CMAKE and not request.with_interfaces:
        raise UsageError(
            "an ament_cmake package here is one of interfaces: nodes in C++ need rclcpp, which "
            "pip does not have",
            hint="--interfaces, or --build-type ament_python",
        )
    if request.build_type == PYTHON and not request.with_nodes:
        raise UsageError(
            "interfaces are generated by CMake, not in an ament_python package",
            hint="leave out --build-type, or add --node for a second package",
        )


def _check_unknown(name: str, known: Iterable[str], env: Mapping[str, str]) -> None:
    """UsageError if there is a package or module of this name."""
    if name in known:
        where = source_packages.find(name) or share_directory(name, env)
        raise UsageError(f"there is a package '{name}' already: {where}", hint="another name")
    place_of_module = name_rules.module_in_environment(name)
    if place_of_module is not None:
        raise UsageError(
            f"'{name}' is a module of this environment, which the package would hide: "
            f"{place_of_module}",
            hint="another name",
        )


def _check_dependencies(
    request: CreateRequest, folder: str, env: Mapping[str, str]
) -> Iterator[str]:
    """Warnings about dependencies; UsageError for one that a package of interfaces cannot have."""
    workspace = find_workspace(target_folder.existing(folder))
    if workspace is not None:  # what it has built counts as well
        env = environment(workspace, env)
    folders = (
        target_folder.sources_of_workspace(folder),
        *map(source_packages.find, request.dependencies),
    )
    found = find_packages(filter(None, folders), env).packages
    manifests = {package.name: package.manifest for package in found}
    known = package_names(env) | {*manifests}
    for name in request.dependencies:
        if (manifest := manifests.get(name)) is not None:  # newer than its build
            has_types = _INTERFACES in manifest.groups
        else:
            has_types = resource_prefix("rosidl_interfaces", name, env) is not None
        if name in known and not has_types and not request.with_nodes:
            raise UsageError(f"--dependencies: '{name}' is not a package of interfaces")
        if name not in known and "-" not in name:
            near = did_you_mean(name, known)
            yield f"no package '{name}' is known{f'; {near}' if near else ''}"


# ---- contents


def _contents(request: CreateRequest, folder: str) -> dict[str, dict[str, str]]:
    person, email = maintainer(request.maintainer, request.email, target_folder.existing(folder))

    def metadata(what: str) -> PackageMetadata:
        description = request.description or f"{TO_DO}: {what} of {request.name}"
        return PackageMetadata(
            description=description,
            license=request.license or TO_DO,
            maintainer=person,
            email=email,
        )

    packages = {}
    if request.interfaces is not None:
        more = () if request.with_nodes else request.dependencies
        packages[request.interfaces] = interface_files(
            request.interfaces, metadata("messages, services and actions"), dependencies=more
        )
    if request.with_nodes:
        packages[request.name] = node_files(
            request.name,
            request.nodes or (f"{request.name}_node",),
            metadata("nodes"),
            dependencies=request.dependencies,
            interfaces=request.interfaces,
        )
    return packages


# ---- what is printed


def _report(
    request: CreateRequest, folder: str, packages: Mapping[str, Mapping[str, str]]
) -> Iterator[str]:
    for name, texts in packages.items():
        files = [os.path.basename(path) for path in texts if _is_example(path)]
        yield f"created {shown(os.path.join(folder, name))}/ with {', '.join(files)}"
    open_fields = [key for key in ("description", "license") if getattr(request, key) is None]
    if any(f'"{UNKNOWN_EMAIL}"' in texts["package.xml"] for texts in packages.values()):
        open_fields.append("maintainer")
    if open_fields:
        where = "package.xml and setup.py" if request.with_nodes else "package.xml"
        yield f"to fill in, in {where}: {', '.join(open_fields)}"
    if target_folder.sources_of_workspace(folder) is None:
        yield (
            "hint: this folder is not in a workspace; to make one: "
            f"mkdir -p ws/src && mv {' '.join(packages)} ws/src/ && cd ws"
        )
    yield "next:"
    yield from (f"  {line}" for line in _next_commands(request, folder))


def _is_example(path: str) -> bool:
    folder = path.partition("/")[0]
    return "/" in path and folder not in ("resource",) and not path.endswith("__init__.py")


def _next_commands(request: CreateRequest, folder: str) -> Iterator[str]:
    name = f"{program()}{_workspace_option(request)}"
    if request.folder is not None:
        yield f"cd {shlex.quote(shown(folder))}"
    yield f"{name} build"
    yield f"{name} test {' '.join(request.packages)}"
    if request.with_nodes:
        launch = " launch" if request.name in request.verbs else ""
        yield f"{name}{launch} {request.name} {request.name}.launch.py"
    if request.interfaces is not None:
        yield f"{name} interface show {request.interfaces}/msg/Count"


def _workspace_option(request: CreateRequest) -> str:
    """` --workspace DIR` if the working directory is not in the workspace of the packages."""
    workspace = os.environ.get(VARIABLE)
    if request.folder is not None or not workspace:
        return ""
    if os.path.realpath(workspace) in target_folder.and_above(os.getcwd()):
        return ""
    return f" --workspace {shlex.quote(shown(workspace))}"


def maintainer(name: str | None, email: str | None, folder: str) -> tuple[str, str]:
    """(name, e-mail), from git's settings for this folder where they are not given; UsageError."""
    if email is not None and not is_email(email):
        raise UsageError(f"--maintainer-email: '{email}' is not an e-mail address")
    known = email or _git("user.email", folder)
    return (
        name or _git("user.name", folder) or _user(),
        known if is_email(known) else UNKNOWN_EMAIL,
    )


def _git(setting: str, folder: str) -> str:
    """The setting; empty if it is not set, or there is no git."""
    try:
        asked = subprocess.run(
            ["git", "config", "--get", setting],
            cwd=folder,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_GIT_TIMEOUT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    value = asked.stdout.strip()
    return value if value.isprintable() else ""


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a user id without a name, as in containers
        return "user"
