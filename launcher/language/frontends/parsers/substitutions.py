"""Parse function of substitutions: words of `$(name word ...)` to keyword arguments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from launcher.language.frontends.errors import AttributeTypeError, UnexpectedContentError
from launcher.language.frontends.parsers.attributes import Parsed

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


@dataclass(frozen=True, slots=True)
class Words:
    """The keyword of each word, in order; the optional ones come last."""

    name: str
    required: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()

    def described(self) -> str:
        words = [self.name, *map(str.upper, self.required)]
        words += [f"[{keyword.upper()}]" for keyword in self.optional]
        return f"$({' '.join(words)})"

    def expectation(self) -> str:
        """How many words there may be, as ROS 2 says it."""
        most = len(self.required) + len(self.optional)
        counts = " or ".join(map(str, range(len(self.required), most + 1)))
        return f"{self.name} substitution expects {counts} argument{'' if counts == '1' else 's'}"


_WORDS = {
    "AndSubstitution": Words("and", ("left", "right")),
    "AnonName": Words("anon", ("name",)),
    "Command": Words("command", ("command",), ("on_stderr",)),
    "EnvironmentVariable": Words("env", ("name",), ("default_value",)),
    "EqualsSubstitution": Words("equals", ("left", "right")),
    "ExecutableInPackage": Words("exec-in-pkg", ("executable", "package")),
    "ForEachVar": Words("for-var", ("name",), ("default_value",)),
    "ForLoopIndex": Words("index", ("name",)),
    "FileContent": Words("file-content", ("path",)),
    "FindExecutable": Words("find-exec", ("name",)),
    "FindPackagePrefix": Words("find-pkg-prefix", ("package",)),
    "FindPackageShare": Words("find-pkg-share", ("package",)),
    "IfElseSubstitution": Words("if", ("condition", "if_value"), ("else_value",)),
    "LaunchConfiguration": Words("var", ("variable_name",), ("default",)),
    "LaunchLogDir": Words("log_dir"),
    "NotEqualsSubstitution": Words("not-equals", ("left", "right")),
    "NotSubstitution": Words("not", ("value",)),
    "OrSubstitution": Words("or", ("left", "right")),
    "Parameter": Words("param", ("name",), ("default",)),
    "PythonExpression": Words("eval", ("expression",), ("python_modules",)),
    "ThisLaunchFile": Words("filename"),
    "ThisLaunchFileDir": Words("dirname"),
}

# Those that take any number of words, and at least this many, and the error for fewer.
_MANY = {
    "AllSubstitution": (0, AttributeTypeError),
    "AnySubstitution": (0, AttributeTypeError),
    "PathJoinSubstitution": (1, UnexpectedContentError),
    "StringJoinSubstitution": (2, AttributeTypeError),
}


def parse_substitution(cls: type, data: Sequence[Any]) -> Parsed:
    """The class and its keyword arguments, for a built-in substitution or a subclass of one."""
    for ancestor in cls.__mro__:
        if ancestor.__name__ in _WORDS:
            return cls, _keywords(_WORDS[ancestor.__name__], data)
    if cls.__name__ in _MANY:
        return cls, _many(cls.__name__, data)
    raise NotImplementedError(f"{cls.__name__} has no class method 'parse'")


def _many(class_name: str, data: Sequence[Any]) -> dict[str, Any]:
    """`string-join` has the delimiter first."""
    fewest, error = _MANY[class_name]
    if len(data) < fewest:
        raise error(f"too few words, {len(data)}", ros_type="VisitError")
    if class_name == "StringJoinSubstitution":
        return {"delimiter": data[0], "substitutions": data[1:]}
    return {"substitutions" if class_name == "PathJoinSubstitution" else "container": data}


def _keywords(words: Words, data: Sequence[Any]) -> dict[str, Any]:
    keywords = (*words.required, *words.optional)
    if not len(words.required) <= len(data) <= len(keywords):
        raise AttributeTypeError(
            f"$({words.name} ...) has {len(data)} words ({words.expectation()})",
            hint=f"usage: {words.described()}",
            ros_type="VisitError",
        )
    arguments = dict(zip(keywords, data, strict=False))
    if "python_modules" in arguments:
        arguments["python_modules"] = _modules(arguments["python_modules"])
    return arguments


def _modules(word: Sequence[Any]) -> list[str]:
    """The names of modules in one word, separated by commas."""
    if not word:
        return []
    names: str = word[0].perform(None)
    return [name.strip() for name in names.split(",")]
