"""The variables of ForEach and ForLoop."""

from __future__ import annotations

from launcher.language.naming import public
from launcher.language.substitution import describe_substitutions, perform_substitutions
from launcher.language.substitutions.configuration import NamedValue

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext


@public("launch.substitutions.for_loop_var")
class ForEachVar(NamedValue):
    """The value of a field in the current iteration of a ForEach."""

    @classmethod
    def get_local_arg_name(cls, name: str) -> str:
        """The name of the local that has the value."""
        return f"ForEachVar__{name}"

    def describe(self) -> str:
        default = describe_substitutions(self.default_value or [])
        name = describe_substitutions(self.name)
        return f"{type(self).__name__}(name={name}, default_value={default})"

    def perform(self, context: LaunchContext) -> str:
        """The value as text; RuntimeError if there is none."""
        name = perform_substitutions(context, self.name)
        values = context.get_locals_as_dict()
        local = self.get_local_arg_name(name)
        if local in values:
            return str(values[local])
        if self.default_value is not None:
            return perform_substitutions(context, self.default_value)
        raise RuntimeError(
            f"No value available for {type(self).__name__} '{name}' and no default value provided"
        )


@public("launch.substitutions.for_loop_var")
class ForLoopIndex(ForEachVar):
    """The index in the current iteration of a ForLoop."""

    def __init__(self, name: object) -> None:
        super().__init__(name)
