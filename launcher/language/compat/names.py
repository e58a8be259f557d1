"""Public modules whose names are imported on first access, by the table."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from types import FrameType, ModuleType

from launcher.base.text import suggest
from launcher.language.compat import compat_table
from launcher.language.diagnostics.origin import caller_origin
from launcher.language.launch_session import current

# Installed ones go first: they have everything, and work with the launcher's `launch`.
TEST_PACKAGES = ("launch_testing", "launch_testing_ros", "launch_pytest")
# Tools and extensions of ROS that launch files import from: an installed one goes first.
TOOL_NAMES = ("ros2launch", "ros2pkg", "tracetools_launch")

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class NameNotProvidedError(ImportError):
    """A launch file imports a name that this launcher does not have."""

    ros_type = "ImportError"


def is_of_tests(module: str) -> bool:
    """Whether only tests of launch files import it."""
    return module.partition(".")[0] in TEST_PACKAGES


def is_of_tool(module: str) -> bool:
    """Whether it is a module of a tool."""
    return module.partition(".")[0] in TOOL_NAMES


def _table(module: str) -> Any:
    if is_of_tests(module):
        from launcher.language.compat import launch_test_table

        return launch_test_table
    if is_of_tool(module):
        from launcher.language.compat import tool_table

        return tool_table
    return compat_table


def is_public(module: str) -> bool:
    """Whether the table has a module of this name."""
    package, _, submodule = module.rpartition(".")
    table = _table(module)
    return module in table.MODULES or submodule in table.SUBMODULES.get(package, ())


def submodules(package: str) -> set[str]:
    """The names of the modules directly in a public package."""
    table = _table(package)
    own = {name.rpartition(".")[2] for name in table.MODULES if name.rpartition(".")[0] == package}
    return own.union(table.SUBMODULES.get(package, ()))


def _sources(module: str) -> dict[str, tuple[str, str]]:
    """Public name -> (module of the launcher, name in it)."""
    table = _table(module)
    if module not in table.MODULES:
        package, _, submodule = module.rpartition(".")
        found = _sources(package)
        return {name: found[name] for name in table.SUBMODULES[package][submodule].split()}
    return {
        public: (source, original or public)
        for source, names in table.MODULES[module].items()
        for public, _, original in (name.partition("=") for name in names.split())
    }


class PublicModule(ModuleType):
    """Imports the source of a name on first access: a launch file loads only what it uses.

    Submodules are attributes, as after ROS 2's own `import launch`. For an unknown name
    `from launch.actions import X` raises NameNotProvidedError; any other access, also that of
    the import system, raises AttributeError.
    """

    def provide(self) -> None:
        self.__dict__["_sources"] = sources = _sources(self.__name__)
        self.__dict__["__all__"] = list(sources)

    def __getattr__(self, name: str) -> Any:
        module, sources = self.__name__, self.__dict__.get("_sources", {})
        if name in sources:
            source, original = sources[name]
            value = getattr(importlib.import_module(source), original)
            if name not in current().watched:
                self.__dict__[name] = value
            else:
                _note_use(name, sys._getframe(1))
            return value
        if not name.startswith("__"):
            submodule = self._submodule(f"{module}.{name}")
            if submodule is not None:
                return submodule
            if _is_from_import(sys._getframe(1)):
                raise NameNotProvidedError(_message(module, name, sorted(sources)), name=name)
        raise AttributeError(f"module '{module}' has no attribute '{name}'")

    def __setattr__(self, name: str, value: object) -> None:
        # The import system binds submodules; a function of the same name takes precedence.
        if not (isinstance(value, ModuleType) and name in self.__dict__.get("_sources", ())):
            super().__setattr__(name, value)

    def _submodule(self, name: str) -> ModuleType | None:
        if "__path__" not in self.__dict__ or importlib.util.find_spec(name) is None:
            return None
        return importlib.import_module(name)


def _message(module: str, name: str, names: list[str]) -> str:
    near = suggest(name, names)
    advice = f"did you mean {near}? " if near else ""
    return (
        f"{module}.{name} is not provided by this launcher ({advice}provided: {', '.join(names)})"
    )


def _is_from_import(frame: FrameType) -> bool:
    return _operation(frame) == "IMPORT_FROM"


def _note_use(name: str, frame: FrameType) -> None:
    """Note that the code names it: here, or below its `import *`; not in `hasattr`."""
    operation = _operation(frame)
    if operation in ("IMPORT_FROM", "LOAD_ATTR", "LOAD_METHOD"):
        current().note_use(name, caller_origin())
    elif operation in ("IMPORT_STAR", "CALL_INTRINSIC_1"):
        # Imported only for a plan.
        from launcher.language.diagnostics import source_code

        current().note_use(name, source_code.first_read(frame.f_code.co_filename, name))


def _operation(frame: FrameType) -> str:
    import opcode

    return opcode.opname[frame.f_code.co_code[frame.f_lasti]]
