"""Re-exports of `launch_xml.parser`."""

from launcher.frontends.xml import XmlParser as Parser
from launcher.language.compat.names import refuse_unknown

__all__ = ["Parser"]

__getattr__ = refuse_unknown("launch_xml.parser", __all__)
