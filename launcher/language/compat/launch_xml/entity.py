"""Re-exports of `launch_xml.entity`."""

from launcher.frontends.entity_xml import XmlEntity as Entity
from launcher.language.compat.names import refuse_unknown

__all__ = ["Entity"]

__getattr__ = refuse_unknown("launch_xml.entity", __all__)
