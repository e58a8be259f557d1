"""`launch.substitutions.file_content`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "FileContent": "launcher.language.substitutions.files",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
