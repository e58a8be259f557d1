"""Re-exports of `launch_yaml`."""

from launcher.frontends.entity_yaml import YamlEntity as Entity
from launcher.frontends.yaml import YamlParser as Parser
from launcher.language.compat.names import refuse_unknown

__all__ = ["Entity", "Parser"]

__getattr__ = refuse_unknown("launch_yaml", __all__)
