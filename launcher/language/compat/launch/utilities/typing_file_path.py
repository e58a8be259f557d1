"""`launch.utilities.typing_file_path`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "FilePath": "launcher.language.some_types",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
