"""`launch.substitutions`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "AllSubstitution": "launcher.language.substitutions.logic",
    "AndSubstitution": "launcher.language.substitutions.logic",
    "AnonName": "launcher.language.substitutions.names",
    "AnySubstitution": "launcher.language.substitutions.logic",
    "Command": "launcher.language.substitutions.command",
    "EnvironmentVariable": "launcher.language.substitutions.environment",
    "EqualsSubstitution": "launcher.language.substitutions.logic",
    "FileContent": "launcher.language.substitutions.files",
    "FindExecutable": "launcher.language.substitutions.files",
    "ForEachVar": "launcher.language.substitutions.names",
    "ForLoopIndex": "launcher.language.substitutions.names",
    "IfElseSubstitution": "launcher.language.substitutions.logic",
    "LaunchConfiguration": "launcher.language.substitutions.configuration",
    "LaunchLogDir": "launcher.language.substitutions.files",
    "LocalSubstitution": "launcher.language.substitutions.configuration",
    "NotEqualsSubstitution": "launcher.language.substitutions.logic",
    "NotSubstitution": "launcher.language.substitutions.logic",
    "OrSubstitution": "launcher.language.substitutions.logic",
    "PathJoinSubstitution": "launcher.language.substitutions.files",
    "PathSubstitution": "launcher.language.substitutions.files",
    "PythonExpression": "launcher.language.substitutions.python",
    "StringJoinSubstitution": "launcher.language.substitutions.text",
    "SubstitutionFailure": "launcher.language.substitution",
    "TextSubstitution": "launcher.language.substitutions.text",
    "ThisLaunchFile": "launcher.language.substitutions.files",
    "ThisLaunchFileDir": "launcher.language.substitutions.files",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
