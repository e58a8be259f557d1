"""`launch_yaml.entity`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Entity": "launcher.frontends.entity_yaml:YamlEntity",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
