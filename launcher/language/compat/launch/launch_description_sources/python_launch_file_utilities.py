"""`launch.launch_description_sources.python_launch_file_utilities`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "InvalidPythonLaunchFileError": "launcher.language.python_file",
    "get_launch_description_from_python_launch_file": "launcher.language.sources",
    "load_python_launch_file_as_module": "launcher.language.python_file",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
