"""`launch.some_actions_type`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.some_types import SomeActionsType, SomeActionsType_types_tuple

__all__ = ["SomeActionsType", "SomeActionsType_types_tuple"]

__getattr__ = refuse_unknown("launch.some_actions_type", __all__)
