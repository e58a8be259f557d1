"""Re-exports of `launch_xml`."""

from launcher.frontends.entity_xml import XmlEntity as Entity
from launcher.frontends.xml import XmlParser as Parser
from launcher.language.compat.names import refuse_unknown

__all__ = ["Entity", "Parser"]

__getattr__ = refuse_unknown("launch_xml", __all__)
