"""`launch.launch_description_sources`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "AnyLaunchDescriptionSource": "launcher.language.sources",
    "FrontendLaunchDescriptionSource": "launcher.language.sources",
    "InvalidFrontendLaunchFileError": "launcher.language.sources:InvalidLaunchFileError",
    "InvalidPythonLaunchFileError": "launcher.language.python_file",
    "PythonLaunchDescriptionSource": "launcher.language.sources",
    "get_launch_description_from_any_launch_file": "launcher.language.sources",
    "get_launch_description_from_frontend_launch_file": "launcher.language.sources",
    "get_launch_description_from_python_launch_file": "launcher.language.sources",
    "load_python_launch_file_as_module": "launcher.language.python_file",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
