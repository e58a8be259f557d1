"""PythonExpression: the value of a Python expression."""

from __future__ import annotations

import importlib
from collections.abc import Iterable

from launcher.language.class_tools import ensure_argument_type
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launcher.posix.dispositions import Endable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.substitutions.python_expression")
class PythonExpression(Substitution):
    """The value of a Python expression; it sees the given modules, and `math` without prefix."""

    expression: list[Substitution] = read_only()
    python_modules: list[list[Substitution]] = read_only()

    def __init__(self, expression: object, python_modules: Any = ["math"]) -> None:  # noqa: B006
        types = (str, Substitution, Iterable)
        ensure_argument_type(expression, types, "expression", "PythonExpression")
        ensure_argument_type(python_modules, types, "python_modules", "PythonExpression")
        self.__expression = normalize_to_list_of_substitutions(expression)
        if isinstance(python_modules, (str, Substitution)):
            python_modules = [python_modules]
        self.__python_modules = [
            normalize_to_list_of_substitutions(module) for module in python_modules
        ]

    def describe(self) -> str:
        """Like `PythonExpr(LaunchConfig('n') + ' > 3', ['math'])`."""
        expression = describe_substitutions(self.expression)
        modules = ", ".join(describe_substitutions(module) for module in self.python_modules)
        return f"PythonExpr({expression}, [{modules}])"

    def perform(self, context: LaunchContext) -> str:
        """The value as text; exceptions of the expression are passed on."""
        names: dict[str, Any] = {}
        for subs in self.python_modules:
            module = importlib.import_module(perform_substitutions(context, subs))
            if module.__name__ == "math":
                names.update(vars(module))
            names[module.__name__] = module
        text = perform_substitutions(context, self.expression)
        try:
            with Endable():
                return str(eval(text, {}, names))
        except Exception as error:
            # Imported only for an error.
            from launcher.language.diagnostics.expressions import explain

            explain(error, text, self, context)
            raise
