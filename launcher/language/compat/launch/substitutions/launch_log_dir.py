"""`launch.substitutions.launch_log_dir`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchLogDir": "launcher.language.substitutions.files",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
