"""package.xml with the lines of its tags.

catkin_pkg, which colcon uses, decides what is valid, but does not report lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from launcher.base import xml_tree
from launcher.base.text import did_you_mean, suggest
from launcher.base.xml_tree import XmlElement, XmlError
from launcher.packages.distribution import ros_variables
from launcher.workspace.building.sources.source_text import PackageText, SourceError

# XmlElement of a dependency -> colcon's kinds.
_KINDS = {
    "depend": ("build", "run"),
    "build_depend": ("build",),
    "buildtool_depend": ("build",),
    "build_export_depend": ("run",),
    "buildtool_export_depend": ("run",),
    "exec_depend": ("run",),
    "run_depend": ("run",),
    "test_depend": ("test",),
}
_OTHER_TAGS = (
    "package", "name", "version", "description", "maintainer", "license", "url", "author",
    "conflict", "replace", "export", "doc_depend", "group_depend", "member_of_group",
)  # fmt: skip


@dataclass(frozen=True)
class Dependency:
    """One dependency; `kinds` are colcon's: build, run, test. `line` is that of its tag."""

    name: str
    tag: str
    kinds: tuple[str, ...]
    line: int


@dataclass(frozen=True)
class Manifest:
    """What a package.xml says, after its conditions."""

    source: PackageText
    name: str
    name_line: int
    version: str
    build_type: str  # `catkin` if none is given, as for colcon
    build_type_line: int | None
    misspelt: tuple[str, int] | None  # a tag that looks like <build_type>, if there is none
    dependencies: tuple[Dependency, ...]
    groups: tuple[str, ...]  # that the package is a member of
    group_dependencies: tuple[tuple[str, int], ...]  # (group, line)
    end_line: int  # of </package>

    def names(self, *kinds: str) -> set[str]:
        """The packages of these kinds of dependencies."""
        return {one.name for one in self.dependencies if {*one.kinds} & {*kinds}}


def read(path: str, env: Mapping[str, str]) -> Manifest:
    """The package.xml at `path`; SourceError for the first mistake in it.

    `env` has the variables of conditions; those of the installed ROS need not be set.
    Without catkin_pkg, which comes with what building needs, conditions are taken as met, and the
    contents of tags are not judged: enough to know the packages.
    """
    source = PackageText(path)
    root = _parse(source)
    try:
        return _manifest(source, root, {"ROS_VERSION": "2", **ros_variables(env), **env})
    except SourceError as error:
        error.package = next((t.text.strip() for t in root.children if t.name == "name"), None)
        raise


def _manifest(source: PackageText, root: XmlElement, env: Mapping[str, str]) -> Manifest:
    _check_tags(source, root)
    name, version = _validated(source, root)
    active = [tag for tag in root.children if _applies(source, tag, env)]
    exports = [below for tag in active if tag.name == "export" for below in tag.children]
    build_types = [
        tag for tag in exports if tag.name == "build_type" and _applies(source, tag, env)
    ]
    if len(build_types) > 1:
        raise source.error("a package has one <build_type>", build_types[1].line, at="<build_type")
    return Manifest(
        source=source,
        name=name,
        name_line=next(tag.line for tag in root.children if tag.name == "name"),
        version=version,
        build_type=build_types[0].text.strip() if build_types else "catkin",
        build_type_line=build_types[0].line if build_types else None,
        misspelt=None if build_types else _like_build_type(exports),
        dependencies=tuple(
            Dependency(tag.text.strip(), tag.name, _KINDS[tag.name], tag.line)
            for tag in active
            if tag.name in _KINDS
        ),
        groups=tuple(tag.text.strip() for tag in active if tag.name == "member_of_group"),
        group_dependencies=tuple(
            (tag.text.strip(), tag.line) for tag in active if tag.name == "group_depend"
        ),
        end_line=root.end_line,
    )


def _like_build_type(exports: Iterable[XmlElement]) -> tuple[str, int] | None:
    near = (one for one in exports if suggest(one.name, ["build_type"]))
    return next(((one.name, one.line) for one in near), None)


def _applies(source: PackageText, tag: XmlElement, env: Mapping[str, str]) -> bool:
    condition = tag.attributes.get("condition")
    if condition is None or not _has_catkin_pkg():
        return True
    from catkin_pkg.condition import evaluate_condition

    try:
        return bool(evaluate_condition(condition, env))
    except ValueError:
        raise source.error(
            f"the condition '{condition}' cannot be understood",
            tag.line,
            at="condition=",
            hint='write for example condition="$ROS_VERSION == 2"',
        ) from None


# ---- validity


def _has_catkin_pkg() -> bool:
    from importlib.util import find_spec

    try:
        return find_spec("catkin_pkg") is not None
    except ValueError:  # it is blocked
        return False


def _validated(source: PackageText, root: XmlElement) -> tuple[str, str]:
    """Name and version."""
    if not _has_catkin_pkg():
        return _text_of(source, root, "name"), _text_of(source, root, "version")
    from catkin_pkg.package import InvalidPackage, parse_package_string

    try:
        package = parse_package_string(source.text, warnings=[])
        return package.name, package.version
    except (InvalidPackage, AssertionError, ValueError) as error:
        message = str(getattr(error, "msg", error)).strip().splitlines()[0].rstrip(".")
        tag = _blamed(message, root)
        hint = None
        if not any(tag.name in message for tag in root.children if tag is not root):
            hint = _missing_tag_hint(message)
        if message.startswith("Invalid email"):  # by the rule of catkin_pkg
            hint = "write it as NAME@HOST.DOMAIN, where DOMAIN has two or more letters"
        raise source.error(message, tag.line, tag.column, hint=hint) from None


def _text_of(source: PackageText, root: XmlElement, name: str) -> str:
    text = next((tag.text.strip() for tag in root.children if tag.name == name), "")
    if not text:
        raise source.error(f"package.xml has no <{name}>", root.line, hint=_missing_tag_hint(name))
    return text


def _blamed(message: str, root: XmlElement) -> XmlElement:
    """The tag that an error of catkin_pkg is about; the root for what is missing."""
    words = re.findall(r"[\w.+@-]+", message)
    tags = [tag for tag in root.children if tag.text.strip() and tag.text.strip() in words]
    tags += [tag for tag in root.children if tag.name in [word.lower() for word in words]]
    duplicate = "single" in message or "must not appear multiple" in message
    return (tags[-1] if duplicate else tags[0]) if tags else root


def _missing_tag_hint(message: str) -> str | None:
    examples = {
        "version": "<version>0.1.0</version>",
        "description": "<description>What it does</description>",
        "maintainer": '<maintainer email="you@example.org">Your Name</maintainer>',
        "license": "<license>MIT</license>",
        "name": "<name>my_package</name>",
    }
    return next((f"add {tag}" for word, tag in examples.items() if word in message), None)


def _check_tags(source: PackageText, root: XmlElement) -> None:
    """Unknown tags, which catkin_pkg reports without a suggestion."""
    if root.name != "package":
        raise source.error(
            f"the outermost tag is <package>, not <{root.name}>", root.line, root.column
        )
    format_ = root.attributes.get("format", "1")
    if format_ not in ("1", "2", "3"):
        raise source.error(
            f"unknown format '{format_}' of package.xml", root.line, at="format", hint="write 3"
        )
    known = [*_KINDS, *_OTHER_TAGS]
    for tag in root.children:
        if tag.name == "build_type":
            raise source.error(
                "<build_type> belongs into <export>",
                tag.line,
                tag.column,
                hint=f"write <export><build_type>{tag.text.strip()}</build_type></export>",
            )
        if tag.name not in known:
            hint = did_you_mean(tag.name, known)
            raise source.error(f"unknown tag <{tag.name}>", tag.line, tag.column, hint=hint)
        if format_ != "1" and tag.name == "run_depend":
            raise source.error(
                f"<run_depend> does not exist in format {format_}",
                tag.line,
                tag.column,
                hint=f"write <exec_depend>{tag.text.strip()}</exec_depend>",
            )


def _parse(source: PackageText) -> XmlElement:
    if not source.text.strip():
        raise source.error("the file is empty", 1)
    try:
        return xml_tree.parse(source.text)
    except XmlError as problem:
        line, column = problem.line or 1, problem.column
        raise source.error(problem.message, line, column, hint=problem.hint) from None
