"""`launch_ros.utilities.plugin_support`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "PluginException": "launcher.language.ros.plugin_support",
    "satisfies_version": "launcher.language.ros.plugin_support",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
