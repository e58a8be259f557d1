"""`launch.substitutions`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitution import SubstitutionFailure
from launcher.language.substitutions.command import Command
from launcher.language.substitutions.configuration import LaunchConfiguration, LocalSubstitution
from launcher.language.substitutions.environment import EnvironmentVariable
from launcher.language.substitutions.files import (
    FileContent,
    FindExecutable,
    LaunchLogDir,
    PathJoinSubstitution,
    PathSubstitution,
    ThisLaunchFile,
    ThisLaunchFileDir,
)
from launcher.language.substitutions.logic import (
    AllSubstitution,
    AndSubstitution,
    AnySubstitution,
    EqualsSubstitution,
    IfElseSubstitution,
    NotEqualsSubstitution,
    NotSubstitution,
    OrSubstitution,
)
from launcher.language.substitutions.names import AnonName, ForEachVar, ForLoopIndex
from launcher.language.substitutions.python import PythonExpression
from launcher.language.substitutions.text import StringJoinSubstitution, TextSubstitution

__all__ = [
    "AllSubstitution",
    "AndSubstitution",
    "AnonName",
    "AnySubstitution",
    "Command",
    "EnvironmentVariable",
    "EqualsSubstitution",
    "FileContent",
    "FindExecutable",
    "ForEachVar",
    "ForLoopIndex",
    "IfElseSubstitution",
    "LaunchConfiguration",
    "LaunchLogDir",
    "LocalSubstitution",
    "NotEqualsSubstitution",
    "NotSubstitution",
    "OrSubstitution",
    "PathJoinSubstitution",
    "PathSubstitution",
    "PythonExpression",
    "StringJoinSubstitution",
    "SubstitutionFailure",
    "TextSubstitution",
    "ThisLaunchFile",
    "ThisLaunchFileDir",
]

__getattr__ = refuse_unknown("launch.substitutions", __all__)
