"""How plans and messages show substitutions and conditions: the same text in every process."""

from __future__ import annotations

import importlib
from typing import Any

import pytest

from launcher.language.compat.compat_table import MODULES
from launcher.language.conditions import (
    Condition,
    IfCondition,
    LaunchConfigurationEquals,
    LaunchConfigurationNotEquals,
    UnlessCondition,
)
from launcher.language.sources import PythonLaunchDescriptionSource
from launcher.language.substitution import (
    Substitution,
    TextSubstitution,
    describe_substitutions,
    description_of,
)
from launcher.language.substitutions.configuration import LaunchConfiguration
from launcher.language.substitutions.files import PathJoinSubstitution
from launcher.language.substitutions.logic import (
    AndSubstitution,
    EqualsSubstitution,
    NotSubstitution,
)

A = LaunchConfiguration("a")
# How each public substitution is made and shown; `{a}` stands for LaunchConfig('a').
SHOWN: dict[str, tuple[tuple[Any, ...], dict[str, Any], str]] = {
    "AllSubstitution": ((A, "1"), {}, "AllSubstitution({a}, '1')"),
    "AndSubstitution": ((A, ["x", A]), {}, "AndSubstitution({a}, 'x' + {a})"),
    "AnonName": ((A,), {}, "AnonName({a})"),
    "AnySubstitution": ((A, NotSubstitution(A)), {}, "AnySubstitution({a}, NotSubstitution({a}))"),
    "Command": ((["ls ", A],), {}, "Command('ls ' + {a})"),
    "EnvironmentVariable": ((A,), {}, "EnvVar({a})"),
    "EqualsSubstitution": ((A, True), {}, "EqualsSubstitution({a}, 'true')"),
    "ExecutableInPackage": (("x", A), {}, "ExecInPkg(pkg={a}, exec='x')"),
    "FileContent": ((A,), {}, "FileContent({a})"),
    "FindExecutable": ((), {"name": A}, "FindExec({a})"),
    "FindPackage": ((A,), {}, "FindPackage(pkg={a})"),
    "FindPackagePrefix": ((A,), {}, "FindPackagePrefix(pkg={a})"),
    "FindPackageShare": ((A,), {}, "FindPackageShare(pkg={a})"),
    "ForEachVar": ((A,), {}, "ForEachVar(name={a}, default_value=)"),
    "ForLoopIndex": ((A,), {}, "ForLoopIndex(name={a}, default_value=)"),
    "IfElseSubstitution": (
        (EqualsSubstitution(A, "b"), "c", A),
        {},
        "IfElseSubstitution(EqualsSubstitution({a}, 'b'), 'c', {a})",
    ),
    "LaunchConfiguration": (("a",), {}, "{a}"),
    "LaunchLogDir": ((), {}, "LaunchLogDir()"),
    "LocalSubstitution": (("event.pid",), {}, "LocalVar('event.pid')"),
    "NotEqualsSubstitution": ((A, "b"), {}, "NotEqualsSubstitution({a}, 'b')"),
    "NotSubstitution": ((A,), {}, "NotSubstitution({a})"),
    "OrSubstitution": ((A, "b"), {}, "OrSubstitution({a}, 'b')"),
    "Parameter": ((A,), {}, "Parameter({a})"),
    "PathJoinSubstitution": (
        ([EqualsSubstitution(A, "b"), "c"],),
        {},
        "PathJoinSubstitution('EqualsSubstitution({a}, 'b'), 'c'')",
    ),
    "PathSubstitution": ((A,), {}, "PathJoinSubstitution('{a}')"),
    "PythonExpression": (([A, " > 1"],), {}, "PythonExpr({a} + ' > 1', ['math'])"),
    "StringJoinSubstitution": (
        ([A, NotSubstitution(A)],),
        {},
        "StringJoin({a}, NotSubstitution({a}))",
    ),
    "Substitution": ((), {}, "Substitution"),
    "TextSubstitution": ((), {"text": "t"}, "'t'"),
    "ThisLaunchFile": ((), {}, "ThisLaunchFile()"),
    "ThisLaunchFileDir": ((), {}, "ThisLaunchFileDir()"),
}


def public_classes(base: type) -> dict[str, type]:
    found = {}
    for sources in MODULES.values():
        for source, names in sources.items():
            module = importlib.import_module(source)
            for name in (word.rpartition("=")[2] for word in names.split()):
                made = getattr(module, name)
                if isinstance(made, type) and issubclass(made, base):
                    found[made.__name__] = made
    return found


SUBSTITUTIONS = public_classes(Substitution)


@pytest.mark.parametrize("name", sorted(SUBSTITUTIONS))
def test_every_substitution_is_shown_without_addresses(name: str):
    words, more, shown = SHOWN[name]
    made = SUBSTITUTIONS[name](*words, **more)
    assert description_of(made) == shown.format(a="LaunchConfig('a')")
    assert describe_substitutions([made, TextSubstitution(text="!")]).endswith(" + '!'")


CONDITIONS = {
    "Condition": (lambda: Condition(predicate=lambda context: True), "Condition"),
    "IfCondition": (
        lambda: IfCondition(AndSubstitution(A, "1")),
        "IfCondition(AndSubstitution(LaunchConfig('a'), '1'))",
    ),
    "LaunchConfigurationEquals": (
        lambda: LaunchConfigurationEquals("a", "b"),
        "LaunchConfigurationEquals('a', 'b')",
    ),
    "LaunchConfigurationNotEquals": (
        lambda: LaunchConfigurationNotEquals("a", None),
        "LaunchConfigurationNotEquals('a', None)",
    ),
    "UnlessCondition": (lambda: UnlessCondition(A), "UnlessCondition(LaunchConfig('a'))"),
}


@pytest.mark.filterwarnings("ignore:.*deprecated")
@pytest.mark.parametrize("name", sorted(public_classes(Condition)))
def test_every_condition_is_shown_without_addresses(name: str):
    make, shown = CONDITIONS[name]
    assert description_of(make()) == shown


class Silent(Substitution):
    """Its `describe` is set by the tests."""


@pytest.mark.parametrize("answer", ["", " \n", None, 5, "Mine(<x object at 0x7f00>)", ValueError()])
def test_a_class_is_shown_by_its_name_if_it_tells_nothing_of_itself(
    answer: object, monkeypatch: pytest.MonkeyPatch
):
    def describe(self: object) -> object:
        if isinstance(answer, Exception):
            raise answer
        return answer

    monkeypatch.setattr(Silent, "describe", describe)
    joined = EqualsSubstitution(Silent(), "x")
    assert description_of(joined) == "EqualsSubstitution(Silent, 'x')"
    assert description_of(IfCondition(Silent())) == "IfCondition(Silent)"
    assert description_of(PathJoinSubstitution([Silent()])) == "PathJoinSubstitution('Silent')"


def test_an_own_description_is_kept():
    class Own(EqualsSubstitution):
        def describe(self) -> str:
            return "mine"

    class Shown(Substitution):
        def __repr__(self) -> str:
            return "<shown>"

    assert describe_substitutions([Own("a", "b"), Shown()]) == "mine + <shown>"


@pytest.mark.parametrize(
    ("location", "shown"),
    [
        ("/a/b.launch.py", "/a/b.launch.py"),
        (["/a/", "b.launch.py"], "/a/b.launch.py"),
        (["/a/", A], "'/a/' + LaunchConfig('a')"),
    ],
)
def test_an_included_file_that_was_not_loaded_is_shown(location: Any, shown: str):
    assert PythonLaunchDescriptionSource(location).location == shown
