"""Sources of launch descriptions: launch files, or an existing description."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from types import ModuleType

from launcher.base import text_file
from launcher.base.text import typed_error
from launcher.language import frontend_registry
from launcher.language.context import LaunchContext
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    plain_text,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.description import LaunchDescription
    from launcher.language.some_types import FilePath
    from launcher.language.substitution import Substitution


_MODULE_NAME = "python_launch_file"  # `__name__` of launch files
_REQUIRED = "generate_launch_description"


@public("launch.invalid_launch_file_error")
class InvalidLaunchFileError(Exception):
    """No loader accepts the launch file."""

    def __init__(
        self, extension: str = "", *, likely_errors: list[Exception] | None = None
    ) -> None:
        self._extension = extension
        self._likely_errors = likely_errors
        if extension == "" or not likely_errors:
            self._error_message = (
                "The launch file may have a syntax error, or its format is unknown"
            )
            return
        count = "multiple exceptions" if len(likely_errors) > 1 else "exception"
        lines = [f"Caught {count} when trying to load file of format [{extension}]:"]
        lines += [f" - {typed_error(error)}" for error in likely_errors]
        self._error_message = "\n".join(lines)
        self.__cause__ = likely_errors[0]

    def __str__(self) -> str:
        return self._error_message


def is_interrupt(error: BaseException | None) -> bool:
    """Whether Python has made it of a KeyboardInterrupt: in __set_name__, before 3.12."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__
    return error is not None


class _Early:
    """A description that was loaded before its visit, with what its file could see then."""

    def __init__(self, location: str, description: LaunchDescription) -> None:
        self._seen = self._surroundings(location)
        self.location = location
        self.description = description

    def is_valid(self, location: str) -> bool:
        """Whether loading this file now would give the same."""
        return location == self.location and self._seen == self._surroundings(location)

    @staticmethod
    def _surroundings(location: str) -> tuple[object, ...]:
        try:
            found = os.stat(location)
            state = (found.st_ino, found.st_size, found.st_mtime_ns)
        except OSError:
            state = None
        return state, dict(os.environ), os.getcwd()


@public("launch.launch_description_source")
class LaunchDescriptionSource:
    """A launch description and its origin; loaded once, on first use."""

    _loaded: LaunchDescription | None = read_only(
        "The description if it was loaded by a visit, or given.", of="__launch_description"
    )
    _location_parts: list[Substitution] = read_only(of="__location")
    method: str = read_only("How the description is loaded.")

    def __init__(
        self,
        launch_description: LaunchDescription | None = None,
        location: object = "<string>",
        method: str = "unspecified mechanism from a script",
    ) -> None:
        self.__launch_description = launch_description
        self.__early: _Early | None = None
        self.__expanded_location: str | None = None
        self.__location = normalize_to_list_of_substitutions(location)
        self.__method = method

    def try_get_launch_description_without_context(self) -> LaunchDescription | None:
        """The description if it can be loaded with an empty context, else None."""
        try:
            return self._load_early(LaunchContext())
        except Exception as error:  # an attempt: errors are reported when it is visited
            if is_interrupt(error):
                raise KeyboardInterrupt from None
            return None

    def _load_early(self, context: LaunchContext) -> LaunchDescription:
        """The description, for a search; the visit takes it unless it would load another one."""
        if self.__launch_description is not None:
            return self.__launch_description
        location = perform_substitutions(context, self.__location)
        if self.__early is None or self.__early.location != location:
            self.__early = _Early(location, self._get_launch_description(location))
        return self.__early.description

    def get_launch_description(self, context: LaunchContext) -> LaunchDescription:
        """The description; raises what its loading raises."""
        if self.__expanded_location is None:
            self.__expanded_location = perform_substitutions(context, self.__location)
        if self.__launch_description is None:
            location, early = self.__expanded_location, self.__early
            if early is not None and early.is_valid(location):
                self.__launch_description = early.description
            else:
                self.__launch_description = self._get_launch_description(location)
        return self.__launch_description

    def _get_launch_description(self, location: str) -> LaunchDescription:
        raise RuntimeError(
            "LaunchDescriptionSource.get_launch_description(): "
            "called without launch description being set"
        )

    @property
    def location(self) -> str:
        """The path once it is known, before that the description of its substitutions."""
        if self.__expanded_location is not None:
            return self.__expanded_location
        text = plain_text(self.__location)
        return describe_substitutions(self.__location) if text is None else text

    @property
    def _is_located(self) -> bool:
        return self.__expanded_location is not None


class _FileSource(LaunchDescriptionSource):
    """Base of sources of a certain kind of launch file."""

    _method = "interpreted launch file"

    def __init__(self, launch_file_path: object) -> None:
        super().__init__(None, launch_file_path, self._method)


@public("launch.launch_description_sources.python_launch_description_source")
class PythonLaunchDescriptionSource(_FileSource):
    """A Python launch file."""

    _method = "interpreted python launch file"

    def _get_launch_description(self, location: str) -> LaunchDescription:
        return get_launch_description_from_python_launch_file(location)


@public("launch.launch_description_sources.any_launch_description_source")
class AnyLaunchDescriptionSource(_FileSource):
    """A launch file of any kind."""

    def _get_launch_description(self, location: str) -> LaunchDescription:
        return get_launch_description_from_any_launch_file(location)


@public("launch.launch_description_sources.frontend_launch_description_source")
class FrontendLaunchDescriptionSource(LaunchDescriptionSource):
    """An XML or YAML launch file."""

    def __init__(
        self,
        launch_file_path: object,
        *,
        method: str = "interpreted frontend launch file",
        parser: Any = None,
    ) -> None:
        super().__init__(None, launch_file_path, method)
        self._parser = parser

    def _get_launch_description(self, location: str) -> LaunchDescription:
        return get_launch_description_from_frontend_launch_file(location, parser=self._parser)


@public("launch_xml.launch_description_sources.xml_launch_description_source")
class XMLLaunchDescriptionSource(_FileSource):
    """An XML launch file."""

    _method = "interpreted XML launch file"

    def _get_launch_description(self, location: str) -> LaunchDescription:
        parser = frontend_registry.parser_class("xml")
        return get_launch_description_from_frontend_launch_file(location, parser=parser)


@public("launch_yaml.launch_description_sources.yaml_launch_description_source")
class YAMLLaunchDescriptionSource(_FileSource):
    """A YAML launch file."""

    _method = "interpreted YAML launch file"

    def _get_launch_description(self, location: str) -> LaunchDescription:
        parser = frontend_registry.parser_class("yaml")
        return get_launch_description_from_frontend_launch_file(location, parser=parser)


@public("launch.launch_description_sources.python_launch_file_utilities")
class InvalidPythonLaunchFileError(Exception):
    """A Python launch file lacks the required function."""


class _Loader(SourceFileLoader):
    """Writes no byte code next to launch files."""

    def get_code(self, fullname: str) -> Any:
        return self.source_to_code(self._source(), self.path)

    def _source(self) -> bytes:
        return text_file.read_bytes(self.path)


class _LaunchFileLoader(_Loader):
    """Executes no program that was given as a launch file: it might never end."""

    def _source(self) -> bytes:
        source = super()._source()
        if _REQUIRED.encode() not in source:
            # Imported only for what is probably an error.
            from launcher.language.diagnostics import programs

            error = _without_function(self.path)
            if programs.explain(error, source, self.path, _REQUIRED):
                raise error
        return source


def load_python_launch_file_as_module(python_launch_file_path: FilePath) -> ModuleType:
    """Execute a launch file as a module; exceptions of the file are passed on."""
    return _module(_Loader(_MODULE_NAME, os.fsdecode(python_launch_file_path)))


def _module(loader: _Loader) -> ModuleType:
    spec = spec_from_loader(_MODULE_NAME, loader)
    if spec is None:
        raise RuntimeError("Failed to load module spec!")
    module = module_from_spec(spec)
    loader.exec_module(module)
    return module


def get_launch_description_from_python_launch_file(
    python_launch_file_path: FilePath,
) -> LaunchDescription:
    """The result of the file's `generate_launch_description()`; its exceptions are passed on."""
    path = os.fsdecode(python_launch_file_path)
    module = _module(_LaunchFileLoader(_MODULE_NAME, path))
    function = getattr(module, _REQUIRED, None)
    if function is None:
        error = _without_function(path)
        # Imported only for an error.
        from launcher.language.diagnostics import launch_tests

        launch_tests.explain(error, module, path)
        raise error
    description: LaunchDescription = function()
    return description


def _without_function(path: str) -> InvalidPythonLaunchFileError:
    return InvalidPythonLaunchFileError(
        f"launch file at '{path}' does not contain the required function '{_REQUIRED}()'"
    )


def get_launch_description_from_frontend_launch_file(
    launch_file_path: FilePath, *, parser: Any = None
) -> LaunchDescription:
    """The description of an XML or YAML file."""
    if not hasattr(parser, "load"):
        parser = frontend_registry.parser_class("")
    root_entity, loaded_parser = parser.load(os.fsdecode(launch_file_path))
    description: LaunchDescription = loaded_parser.parse_description(root_entity)
    return description


def get_launch_description_from_any_launch_file(
    launch_file_path: FilePath, *, parser: Any = None
) -> LaunchDescription:
    """The description of a file of any kind; InvalidLaunchFileError if no loader accepts it.

    Its `__cause__` is the error of the loader that the file's suffix suggests.
    """
    launch_file_path = os.fsdecode(launch_file_path)
    extension = launch_file_path.rpartition("/")[2].rpartition(".")[2]
    is_markup = extension in ("xml", "yaml", "yml")
    likely: list[Exception] = []
    # A file with an unknown suffix is far more often Python than markup.
    loaders: list[Callable[[str], LaunchDescription]] = [
        get_launch_description_from_python_launch_file,
        get_launch_description_from_frontend_launch_file,
    ]
    for loader in reversed(loaders) if is_markup else loaders:
        try:
            return loader(launch_file_path)
        except Exception as error:
            likely.append(error)
    known = extension if is_markup or extension == "py" else ""
    raise InvalidLaunchFileError(known, likely_errors=likely) from likely[0]
