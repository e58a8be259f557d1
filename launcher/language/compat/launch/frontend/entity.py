"""Re-exports of `launch.frontend.entity`."""

from launcher.frontends.entity import Entity
from launcher.language.compat.names import refuse_unknown

__all__ = ["Entity"]

__getattr__ = refuse_unknown("launch.frontend.entity", __all__)
