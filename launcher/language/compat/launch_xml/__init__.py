"""`launch_xml`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Entity": "launcher.frontends.entity_xml:XmlEntity",
    "Parser": "launcher.frontends.xml:XmlParser",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
