"""Names that were proposed for ROS 2 and are in no release, and what to write instead."""

from __future__ import annotations

# Name in Python -> (name in XML and YAML, instead of it in Python, in XML and YAML).
_PROPOSED = {
    "AmentIndexResource": (
        "ament-index-resource",
        "ament_index_python.get_resource(TYPE, NAME) in an OpaqueFunction",
        "$(find-pkg-prefix PACKAGE)",
    ),
    "FindLaunchfile": (
        "find-launchfile",
        "PathJoinSubstitution([FOLDER, 'NAME.launch.py'])",
        "FOLDER/NAME.launch.xml",
    ),
    "FindPackageFile": (
        "find-pkg-file",
        "PathJoinSubstitution([FindPackageShare(PACKAGE), FILE])",
        "$(find-pkg-share PACKAGE)/FILE",
    ),
    "IsEmptySubstitution": (
        "is-empty",
        "EqualsSubstitution(VALUE, '')",
        "$(equals VALUE '')",
    ),
    "NotEmptySubstitution": (
        "not-empty",
        "NotEqualsSubstitution(VALUE, '')",
        "$(not-equals VALUE '')",
    ),
    "StringStripSubstitution": (
        "string-strip",
        "PythonExpression([\"'''\", VALUE, \"'''.strip()\"])",
        "$(eval \"'VALUE'.strip()\")",
    ),
}


def of_python(name: str) -> str | None:
    """The hint for a class; None if it was not proposed."""
    return _hint(_PROPOSED[name][1]) if name in _PROPOSED else None


def of_module(name: str) -> str | None:
    """The hint for a module of one class."""
    return of_python(name.title().replace("_", ""))


def of_word(word: str) -> str | None:
    """The hint for a substitution `$(word ...)`."""
    return next((_hint(instead) for name, _, instead in _PROPOSED.values() if name == word), None)


def _hint(instead: str) -> str:
    return f"no release of ROS 2 has it; write {instead}"
