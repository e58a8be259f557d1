"""`launch_testing`, re-exported; what is not here is looked up in an installed one."""

from pkgutil import extend_path

from launcher.language.compat.names import reexport

_SOURCES = {
    "parametrize": "launcher.language.testing",
    "post_shutdown_test": "launcher.language.testing",
}

__all__ = list(_SOURCES)

__path__ = extend_path(__path__, __name__)

__getattr__ = reexport(__name__, _SOURCES)
