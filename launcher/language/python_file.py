"""Python launch files: executing one, and calling its `generate_launch_description()`."""

from __future__ import annotations

from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from types import ModuleType

from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_MODULE_NAME = "python_launch_file"  # what launch files find in their __name__
_REQUIRED = "generate_launch_description"


@public("launch.launch_description_sources.python_launch_file_utilities")
class InvalidPythonLaunchFileError(Exception):
    """A Python launch file lacks the required function."""


class _Loader(SourceFileLoader):
    """Executes the source as it is on disk: no byte code is written next to launch files."""

    def get_code(self, fullname: str) -> Any:
        return self.source_to_code(self.get_data(self.path), self.path)


def load_python_launch_file_as_module(python_launch_file_path: str) -> ModuleType:
    """Execute a launch file as a module; raises whatever the file raises."""
    loader = _Loader(_MODULE_NAME, python_launch_file_path)
    spec = spec_from_loader(_MODULE_NAME, loader)
    if spec is None:
        raise RuntimeError("Failed to load module spec!")
    module = module_from_spec(spec)
    loader.exec_module(module)
    return module


def generate(path: str) -> Any:
    """What the file's `generate_launch_description()` returns."""
    module = load_python_launch_file_as_module(path)
    function = getattr(module, _REQUIRED, None)
    if function is None:
        raise InvalidPythonLaunchFileError(
            f"launch file at '{path}' does not contain the required function '{_REQUIRED}()'"
        )
    return function()
