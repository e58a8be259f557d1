"""`launch.utilities.ensure_argument_type_impl`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ensure_argument_type": "launcher.language.utilities",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
