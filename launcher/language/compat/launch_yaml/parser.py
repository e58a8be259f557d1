"""Re-exports of `launch_yaml.parser`."""

from launcher.frontends.yaml import YamlParser as Parser
from launcher.language.compat.names import refuse_unknown

__all__ = ["Parser"]

__getattr__ = refuse_unknown("launch_yaml.parser", __all__)
