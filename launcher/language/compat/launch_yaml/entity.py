"""Re-exports of `launch_yaml.entity`."""

from launcher.frontends.entity_yaml import YamlEntity as Entity
from launcher.language.compat.names import refuse_unknown

__all__ = ["Entity"]

__getattr__ = refuse_unknown("launch_yaml.entity", __all__)
