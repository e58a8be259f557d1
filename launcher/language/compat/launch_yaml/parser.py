"""`launch_yaml.parser`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Parser": "launcher.frontends.yaml:YamlParser",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
