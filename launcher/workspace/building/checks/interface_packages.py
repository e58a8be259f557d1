"""Checks interface packages: what CMakeLists.txt lists, and the interface files."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from launcher.base.text import did_you_mean, suggest
from launcher.workspace.building.checks import origins
from launcher.workspace.building.checks.interface_files import SUFFIXES, InterfaceFile, Reference
from launcher.workspace.building.checks.interface_index import (
    IMPLICIT,
    Generated,
    InterfaceIndex,
    files_of,
    folder_of,
    interface_name,
)
from launcher.workspace.building.checks.interface_names import Fields, recursions, same_names
from launcher.workspace.building.sources import Package
from launcher.workspace.building.sources.cmake_file import CMakeFile
from launcher.workspace.building.sources.source_text import SourceError, SourceWarning, shown

_GROUP = "rosidl_interface_packages"
_GENERATORS = re.compile(r"rosidl_\w*|\w+_generators")


def check_interfaces(
    package: Package, file: CMakeFile, index: InterfaceIndex
) -> Iterator[SourceError]:
    """The mistakes of a package that calls rosidl_generate_interfaces; nothing for others."""
    calls = file.named("rosidl_generate_interfaces")
    if not calls:
        if not file.has("rosidl_generate_interfaces") and not file.may_do_more:
            yield from _never_generated(package, file)
        return
    rules = [*_package_rules(package, file, index)]
    yield from rules
    if any(not isinstance(one, SourceWarning) for one in rules):
        return
    listed: set[str] = set()
    fields: Fields = {}
    for command in calls:
        call = Generated(command)
        for word, line, keyword in call.misspelt:
            message = f"rosidl_generate_interfaces() has no keyword '{word}'"
            yield file.source.error(message, line, at=word, hint=f"did you mean '{keyword}'?")
        yield from _dependencies(call, file, index)
        checker = _Files(package, file, call, index)
        yield from checker.problems()
        listed |= checker.listed
        fields |= checker.fields
    yield from same_names(file.source, (one for call in calls for one in Generated(call).files))
    yield from recursions(fields)
    if index.is_complete(package.name):
        for path in files_of(package):
            if path not in listed:
                yield file.source.warning(
                    f"{path} is not listed in rosidl_generate_interfaces, and is not built",
                    calls[0].line,
                    hint=f'add "{path}", or remove the file',
                )


def _never_generated(package: Package, file: CMakeFile) -> Iterator[SourceError]:
    files = files_of(package)
    if files:
        yield file.source.warning(
            f"{files[0]} is not built: CMakeLists.txt does not call rosidl_generate_interfaces",
            hint=f'add rosidl_generate_interfaces(${{PROJECT_NAME}} "{files[0]}") '
            "before ament_package()",
        )


def _package_rules(
    package: Package, file: CMakeFile, index: InterfaceIndex
) -> Iterator[SourceError]:
    """What rosidl demands of a package with interfaces."""
    manifest = package.manifest
    (call, *_) = file.named("rosidl_generate_interfaces")
    flags = {word for one in file.named("rosidl_generate_interfaces") for word in one.words}
    if manifest is not None:
        if not re.fullmatch(r"(?!.*__)[a-z][a-z0-9_]*(?<!_)", package.name):
            yield manifest.source.error(
                f"'{package.name}' is not a valid name of a package with interfaces: lower case "
                "letters, digits and single underscores, beginning with a letter",
                manifest.name_line,
                at=package.name,
            )
        is_exempt = {"SKIP_GROUP_MEMBERSHIP_CHECK", "SKIP_INSTALL"} & flags
        if _GROUP not in manifest.groups and not is_exempt:
            yield manifest.source.error(
                "package.xml does not say that the package has interfaces",
                manifest.end_line,
                hint=f"add <member_of_group>{_GROUP}</member_of_group>",
            )
    found = _found(file, call.line)
    if found is not None and not any(map(_GENERATORS.fullmatch, found)):
        report = file.source.error if index.are_plain(found) else file.source.warning
        yield report(
            "rosidl_generate_interfaces() needs find_package(rosidl_default_generators REQUIRED) "
            "before it",
            call.line,
        )
    end = next(iter(file.named("ament_package")), None)
    if end is not None and end.line < call.line:
        message = f"rosidl_generate_interfaces() must be before ament_package(), in line {end.line}"
        yield file.source.error(message, call.line)


def _found(file: CMakeFile, line: int) -> set[str] | None:
    """The packages that find_package may have found before a line; None if not all are known."""
    finding = [
        one
        for one in (*file.commands, *file.conditional)
        if one.name == "find_package" and one.line <= line
    ]
    if file.may_do_more or not all(one.is_complete for one in finding):
        return None
    return {name for one in finding for name in one.words[:1]}


def _dependencies(call: Generated, file: CMakeFile, index: InterfaceIndex) -> Iterator[SourceError]:
    """DEPENDENCIES that no find_package looks for."""
    found = _found(file, call.line)
    if found is None:
        return
    reachable = index.reachable(found)
    for name, line in call.dependencies:
        if name in reachable:
            continue
        if index.has(name):
            message = f"'{name}' in DEPENDENCIES needs find_package({name} REQUIRED) before it"
            hint = f"add it, and <depend>{name}</depend> to package.xml"
        else:
            message, hint = origins.missing(name, index.packages)
        report = file.source.error if index.are_plain(found) else file.source.warning
        yield report(message, line, at=name, hint=hint)


class _Files:
    """The interface files of one call."""

    def __init__(
        self, package: Package, file: CMakeFile, call: Generated, index: InterfaceIndex
    ) -> None:
        self._package = package
        self._file = file
        self._call = call
        self._index = index
        self._own = index.of(package.name)
        self._dependencies = {name for name, _ in call.dependencies}
        self._reachable = index.reachable(self._dependencies)
        self.listed: set[str] = set()  # paths relative to the package
        self.fields: Fields = {}

    def problems(self) -> Iterator[SourceError]:
        if not self._call.files and self._call.is_complete:
            hint = next((f'add "{path}"' for path in files_of(self._package)), None)
            message = "rosidl_generate_interfaces() lists no interface files"
            yield self._file.source.error(message, self._call.line, hint=hint)
        for text, line in self._call.files:
            yield from self._listed(text, line)

    def _listed(self, text: str, line: int) -> Iterator[SourceError]:
        path = os.path.join(self._file.folder, text)
        if os.path.isabs(text):
            path = "/".join(text.rsplit(":", 1))
        self.listed.add(os.path.normpath(os.path.relpath(path, self._file.folder)))
        if os.path.isabs(text) and ":" not in text:
            yield self._file.source.error(
                "rosidl_generate_interfaces() takes paths relative to the package",
                line,
                hint="write file(GLOB NAME RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} msg/*.msg)",
            )
            return
        if not os.path.isfile(path):
            yield self._missing(text, line)
            return
        wrong = self._wrong_place(text, line)
        if wrong is not None:
            yield wrong
            return
        interface = InterfaceFile(self._package.name, path)
        yield from interface.problems
        if folder_of(text) == "msg":
            own = [one for one in interface.references if one.package == self._package.name]
            self.fields[interface.name] = (interface.source, own)
        for reference in interface.references:
            yield from self._resolved(interface, reference)

    def _missing(self, text: str, line: int) -> SourceError:
        if os.path.isdir(os.path.join(self._file.folder, text)):
            return self._file.source.error(f"'{text}' is a folder, not a file", line, at=text)
        files = files_of(self._package)
        by_name = [path for path in files if os.path.basename(path) == os.path.basename(text)]
        hint = f"did you mean '{by_name[0]}'?" if by_name else did_you_mean(text, files)
        message = f"the interface file '{text}' does not exist"
        report = self._file.source.warning if self._file.makes_files else self._file.source.error
        return report(message, line, at=text, hint=hint)

    def _wrong_place(self, text: str, line: int) -> SourceError | None:
        name = os.path.basename(text)
        suffix = os.path.splitext(name)[1]
        folder = folder_of(text)
        if suffix not in SUFFIXES:
            message = f"'{text}' is not an interface file"
            hint = f"these end with {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
            return self._file.source.error(message, line, at=text, hint=hint)
        kind = suffix.removeprefix(".")
        if not folder:
            wanted = "msg" if suffix == ".idl" else kind
            message = f"{suffix} files must be in a folder, such as '{wanted}'"
        else:
            lacking = self._lacking(kind)
            if not lacking:
                return None
            wanted = kind
            message = f"{suffix} files outside of '{kind}/' need {lacking} in DEPENDENCIES"
        hint = f"move it to {wanted}/{name}"
        return self._file.source.error(message, line, at=text, hint=hint)

    def _lacking(self, kind: str) -> str | None:
        """What a service or an action uses that rosidl adds only for the folders of these."""
        needed = {"srv": IMPLICIT[:1], "action": IMPLICIT}.get(kind, ())
        if not self._call.is_complete or not self._index.are_plain(self._dependencies):
            return None
        folders = {folder_of(text) for text, _ in self._call.files}
        added = IMPLICIT if "action" in folders else IMPLICIT[: "srv" in folders]
        there = self._index.reachable(self._dependencies, implicit=added)
        return next((one for one in needed if one not in there), None)

    # ---- types of fields

    def _resolved(self, file: InterfaceFile, reference: Reference) -> Iterator[SourceError]:
        package, name = reference.package, f"msg/{reference.name}"
        index, source = self._index, file.source
        report = source.error if index.is_complete(package) else source.warning
        if package == self._package.name:
            if name not in self._own:
                yield self._unknown_own(file, reference)
        elif package in index.environment.assumed:
            return
        elif not index.has(package) and not index.is_in_workspace(package):
            known = [one for one in index.packages if one != package]
            message, origin = origins.missing(package, known)
            report = source.warning if self._may_be_there(package) else source.error
            yield report(message, reference.line, at=reference.written, hint=origin)
        elif name not in index.of(package):
            known = [one.split("/")[1] for one in index.of(package) if one[:4] == "msg/"]
            hint = did_you_mean(reference.name, sorted(known)) or self._other(reference.name)
            message = f"{package} has no message '{reference.name}'"
            yield report(message, reference.line, at=reference.written, hint=hint)
        elif package not in self._reachable and self._call.is_complete:
            place = f"{shown(self._file.source.path)}:{self._call.line}"
            is_known = index.are_plain(self._dependencies)
            report = source.error if is_known else source.warning
            yield report(
                f"'{package}' is missing in the DEPENDENCIES of rosidl_generate_interfaces",
                reference.line,
                at=reference.written,
                hint=f"add it in {place}, with find_package({package} REQUIRED) before, and "
                f"<depend>{package}</depend> in package.xml",
            )

    def _may_be_there(self, package: str) -> bool:
        """Whether CMake may find a package that has no interfaces as far as is known."""
        environment = self._index.environment
        if package in environment.packages or package not in self._dependencies:
            return False
        is_found = environment.has_cmake(package)
        return is_found or self._index.may_be_elsewhere(self._package, package)

    def _unknown_own(self, file: InterfaceFile, reference: Reference) -> SourceError:
        name = reference.name
        if f"msg/{name}" in map(interface_name, files_of(self._package)):
            place = f"{shown(self._file.source.path)}:{self._call.line}"
            message = f"msg/{name}.msg is not listed in rosidl_generate_interfaces"
            hint: str | None = f'add "msg/{name}.msg" in {place}'
        else:
            own = sorted(one[4:] for one in self._own if one[:4] == "msg/" and one[4:] != file.name)
            message = f"unknown type '{reference.written}'"
            hint = self._other(name) or did_you_mean(name, [*own, "string", "bool"])
            others = {one.partition("/")[2]: one for one in self._index.messages}
            others = {k: v for k, v in others.items() if f"{self._package.name}/" not in v}
            similar = None if hint else suggest(name, others)
            hint = f"did you mean '{others[similar]}'?" if similar else hint
        report = file.source.error
        if not self._index.is_complete(self._package.name):
            report, hint = file.source.warning, None
            message = f"'{reference.written}' is none of the types that are known before CMake runs"
        return report(message, reference.line, at=reference.written, hint=hint)

    def _other(self, name: str) -> str | None:
        """The message of this name in another package, preferably in a common one."""
        having = [one for one in self._index.messages if one.endswith(f"/{name}")]
        usual = sorted(having, key=lambda one: not one.startswith(("std_msgs/", "geometry_msgs/")))
        return f"write {usual[0]}" if usual else None
