"""Substitutions and typed values: properties, and edge cases of ROS 2."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any, List  # noqa: UP035 - launch files spell list types like this

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.language import type_utils
from launcher.language.actions.configuration import SetLaunchConfiguration
from launcher.language.actions.event_actions import LogInfo
from launcher.language.conditions import (
    InvalidConditionExpressionError,
    evaluate_condition_expression,
)
from launcher.language.context import LaunchContext
from launcher.language.ros.packages import (
    ExecutableInPackage,
    FindPackagePrefix,
    FindPackageShare,
)
from launcher.language.ros.parameter_values import evaluate_parameter_dict, normalize_parameter_dict
from launcher.language.substitution import (
    Substitution,
    SubstitutionFailure,
    TextSubstitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launcher.language.substitutions.configuration import (
    EnvironmentVariable,
    LaunchConfiguration,
    LocalSubstitution,
)
from launcher.language.substitutions.files import (
    FileContent,
    PathJoinSubstitution,
    PathSubstitution,
    ThisLaunchFileDir,
)
from launcher.language.substitutions.for_loop_var import ForEachVar, ForLoopIndex
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
from launcher.language.substitutions.python import PythonExpression
from launcher.language.substitutions.text import StringJoinSubstitution
from tests.language.unit.interpreter.interpreting import logged

texts = st.text(max_size=12)
parts = st.lists(st.one_of(texts, texts.map(lambda text: TextSubstitution(text=text))), max_size=6)


def performed(subs: Any, **configurations: str) -> str:
    context = LaunchContext()
    context.launch_configurations.update(configurations)
    return perform_substitutions(context, normalize_to_list_of_substitutions(subs))


def plain(part: str | TextSubstitution) -> str:
    return part if isinstance(part, str) else part.text


@given(parts)
def test_performing_a_list_joins_its_parts(items: list[Any]):
    assert performed(items) == "".join(plain(item) for item in items)


@given(parts, parts)
def test_performing_is_a_homomorphism(left: list[Any], right: list[Any]):
    assert performed(left + right) == performed(left) + performed(right)


@given(parts)
def test_normalising_twice_changes_nothing(items: list[Any]):
    once = normalize_to_list_of_substitutions(items)

    assert normalize_to_list_of_substitutions(once) == once


@given(texts)
def test_a_configuration_is_what_was_set_last(value: str):
    entities = [
        SetLaunchConfiguration("x", "first"),
        SetLaunchConfiguration("x", [TextSubstitution(text=value)]),
        LogInfo(msg=LaunchConfiguration("x")),
    ]

    assert logged(*entities) == [value]


@given(
    name=st.from_regex(r"LAUNCHER_TEST_[A-Z]{1,8}", fullmatch=True), value=st.text("ab", max_size=5)
)
def test_an_environment_variable_is_its_value_else_the_default(name: str, value: str):
    substitution = EnvironmentVariable(name, default_value="none")
    before = performed(substitution)
    os.environ[name] = value
    try:
        assert (before, performed(substitution)) == ("none", value)
    finally:
        del os.environ[name]


@given(st.booleans(), st.booleans())
def test_boolean_substitutions_follow_logic(left: bool, right: bool):
    one, other = str(left), str(right).lower()
    truth = {True: "true", False: "false"}

    assert performed(AndSubstitution(one, other)) == truth[left and right]
    assert performed(OrSubstitution(one, other)) == truth[left or right]
    assert performed(AnySubstitution(one, other)) == truth[left or right]
    assert performed(AllSubstitution(one, other)) == truth[left and right]
    assert performed(NotSubstitution(one)) == truth[not left]
    assert performed(IfElseSubstitution(one, "yes", "no")) == ("yes" if left else "no")


@given(texts, texts)
def test_unequal_is_the_opposite_of_equal(left: str, right: str):
    assert {
        performed(EqualsSubstitution(left, right)),
        performed(NotEqualsSubstitution(left, right)),
    } == {"true", "false"}


@given(st.floats(allow_nan=False, allow_infinity=False), st.integers(0, 3))
def test_equal_numbers_are_equal_however_they_are_written(number: float, zeros: int):
    written = repr(number) if "e" in repr(number) else repr(number) + "0" * zeros

    assert performed(EqualsSubstitution(repr(number), written)) == "true"


@pytest.mark.parametrize("text", ["true", " True", "1", "TRUE ", "false", "0", "False"])
def test_conditions_take_four_words_in_any_case(text: str):
    expected = text.strip().lower() in ("true", "1")

    assert evaluate_condition_expression(LaunchContext(), [TextSubstitution(text=text)]) is expected


@given(texts.filter(lambda t: t.strip().lower() not in ("true", "1", "false", "0")))
def test_conditions_take_nothing_else(text: str):
    with pytest.raises(InvalidConditionExpressionError, match="expected one of"):
        evaluate_condition_expression(LaunchContext(), [TextSubstitution(text=text)])


@given(st.lists(st.text("ab./", max_size=5), max_size=4))
def test_paths_join_like_pathlib(components: list[str]):
    assert performed(PathJoinSubstitution(components)) == str(Path(*components))


def test_a_path_grows_with_slashes_and_joins_the_parts_of_a_list():
    path = PathSubstitution(["/t", "op"]) / "share" / [LaunchConfiguration("robot"), ".urdf"]

    assert performed(path, robot="r2") == "/t/op/share/r2.urdf"


def test_a_path_below_may_be_a_list_a_path_or_a_substitution(tmp_path: Path):
    path = PathJoinSubstitution(["/t", "a"]) / LaunchConfiguration("robot") / Path("b/c")
    assert performed(path, robot="1") == "/t/a/1/b/c"
    assert performed(path / (TextSubstitution(text="d"), ".urdf"), robot="1") == "/t/a/1/b/c/d.urdf"
    assert (path / ["d", ".urdf"]).describe().endswith(", 'd' + '.urdf'')")
    assert performed(PathSubstitution(tmp_path) / "x") == str(tmp_path / "x")
    (tmp_path / "x").write_text("content")
    assert performed(FileContent(tmp_path / "x")) == "content"


def test_a_path_below_the_folder_of_the_launch_file():
    context = LaunchContext()
    context.extend_locals({"current_launch_file_directory": "/t"})
    assert (ThisLaunchFileDir() / "config" / "a.yaml").perform(context) == "/t/config/a.yaml"


def test_a_value_of_an_iteration_is_a_local():
    context = LaunchContext()
    with pytest.raises(RuntimeError, match="ForEachVar 'robot'"):
        ForEachVar("robot").perform(context)
    assert ForEachVar("robot", default_value="none").perform(context) == "none"
    context.extend_locals({ForEachVar.get_local_arg_name("robot"): 1})
    assert ForEachVar(["ro", "bot"]).perform(context) == "1"
    assert ForLoopIndex("robot").perform(context) == "1"


def test_joining_uses_the_delimiter():
    assert performed(StringJoinSubstitution([["a", "b"], "c"], delimiter=", ")) == "ab, c"


@given(st.integers(-1000, 1000), st.integers(-1000, 1000))
def test_a_python_expression_calculates(left: int, right: int):
    assert performed(PythonExpression([str(left), " + ", str(right)])) == str(left + right)


def test_a_python_expression_knows_math_with_and_without_its_name():
    assert performed(PythonExpression("floor(2.5) + math.ceil(2.5)")) == "5"


@pytest.mark.parametrize("expression", ["event.pid", "bag['key']", "bag['key'].upper()"])
def test_locals_can_be_reached_with_python(expression: str):
    class Event:
        pid = 7

    context = LaunchContext()
    context.extend_locals({"event": Event(), "bag": {"key": "v"}})

    assert perform_substitutions(context, [LocalSubstitution(expression)]) in ("7", "v", "V")


scalars = st.one_of(
    st.booleans(),
    st.integers(-(10**9), 10**9),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(st.characters(codec="utf-8", exclude_categories=["C"]), min_size=1, max_size=8),
)


@given(scalars)
def test_a_parameter_keeps_its_type_and_value(value: Any):
    evaluated = evaluate_parameter_dict(LaunchContext(), normalize_parameter_dict({"p": value}))

    assert evaluated == {"p": value}
    assert type(evaluated["p"]) is type(value)


@given(
    st.recursive(
        st.integers(),
        lambda inner: st.dictionaries(st.text("ab", min_size=1), inner, min_size=1),
        max_leaves=6,
    )
)
def test_nested_parameters_are_flattened_with_dots(tree: Any):
    def flat(prefix: str, node: Any) -> dict[str, Any]:
        if not isinstance(node, dict):
            return {prefix: node}
        return {k: v for key, sub in node.items() for k, v in flat(f"{prefix}.{key}", sub).items()}

    evaluated = evaluate_parameter_dict(LaunchContext(), normalize_parameter_dict({"p": tree}))

    assert evaluated == flat("p", tree)


@given(st.one_of(st.lists(st.integers(), min_size=1), st.lists(st.booleans(), min_size=1)))
def test_a_uniform_list_is_a_tuple_of_its_items(values: list[Any]):
    evaluated = evaluate_parameter_dict(LaunchContext(), normalize_parameter_dict({"p": values}))

    assert evaluated == {"p": tuple(values)}


@given(st.lists(st.one_of(st.integers(-9, 9), st.floats(-9, 9)), min_size=1))
def test_a_list_of_numbers_with_one_float_is_all_floats(values: list[Any]):
    evaluated = evaluate_parameter_dict(LaunchContext(), normalize_parameter_dict({"p": values}))

    wanted = float if any(isinstance(value, float) for value in values) else int
    assert {type(item) for item in evaluated["p"]} == {wanted}


@given(st.integers())
def test_a_text_is_coerced_to_the_type_that_is_asked_for(number: int):
    text = str(number)

    assert type_utils.get_typed_value(text, int) == number
    assert type_utils.get_typed_value(text, str) == text
    assert type_utils.get_typed_value([text], List[int]) == [number]  # noqa: UP006
    assert math.isclose(type_utils.get_typed_value(text, float), number)


@pytest.mark.parametrize(
    ("value", "data_type", "error"),
    [
        ("true", bool, TypeError),
        (1, float, TypeError),
        ([1, "a"], None, TypeError),
        (["1"], List[int], TypeError),  # noqa: UP006
        ([1.0], float, TypeError),
        (object(), None, TypeError),
    ],
)
def test_a_value_of_another_type_is_refused_at_once(value: Any, data_type: Any, error: Any):
    with pytest.raises(error):
        type_utils.normalize_typed_substitution(value, data_type)


def test_a_list_of_substitution_lists_is_a_list_of_values():
    value = type_utils.normalize_typed_substitution(
        [[LaunchConfiguration("n")], [LaunchConfiguration("n"), "0"]],
        List[int],  # noqa: UP006
    )
    context = LaunchContext()
    context.launch_configurations["n"] = "4"

    assert type_utils.perform_typed_substitution(context, value, List[int]) == [4, 40]  # noqa: UP006


def test_a_substitution_of_the_launch_file_is_performed():
    class Loud(Substitution):
        def __init__(self, inner: Substitution) -> None:
            super().__init__()
            self.inner = inner

        def perform(self, context: LaunchContext) -> str:
            return context.perform_substitution(self.inner).upper()

    assert performed(Loud(LaunchConfiguration("word")), word="quiet") == "QUIET"


@pytest.mark.parametrize(
    "substitution",
    [
        LaunchConfiguration("nobody"),
        EnvironmentVariable("LAUNCHER_TEST_NOBODY"),
        NotSubstitution("maybe"),
    ],
    ids=lambda substitution: type(substitution).__name__,
)
def test_what_cannot_be_performed_is_a_substitution_failure(substitution: Substitution):
    with pytest.raises(SubstitutionFailure):
        performed(substitution)


@pytest.mark.parametrize("name", ["", "x", "_demo", "-demo", "no such name!", "déjà", "a/b"])
@pytest.mark.parametrize(
    "make",
    [FindPackagePrefix, FindPackageShare, lambda name: ExecutableInPackage("talker", name)],
    ids=["prefix", "share", "executable"],
)
def test_an_invalid_package_name_is_a_value_error(make, name):
    with pytest.raises(ValueError, match=f"'{name}' is not a valid package name"):
        make(name).perform(LaunchContext())
