"""`launch_yaml`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Entity": "launcher.frontends.entity_yaml:YamlEntity",
    "Parser": "launcher.frontends.yaml:YamlParser",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
