"""`launch_xml.parser`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Parser": "launcher.frontends.xml:XmlParser",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
