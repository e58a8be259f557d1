"""`launch`: our vocabulary under ROS 2's name."""

from launcher.language.action import Action
from launcher.language.compat.names import refuse_unknown
from launcher.language.condition import Condition
from launcher.language.context import LaunchContext
from launcher.language.description import LaunchDescription
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.event import Event
from launcher.language.event_handler import EventHandler
from launcher.language.introspection import LaunchIntrospector
from launcher.language.service import LaunchService
from launcher.language.some_types import SomeEntitiesType, SomeEntitiesType_types_tuple
from launcher.language.sources import InvalidLaunchFileError, LaunchDescriptionSource
from launcher.language.substitution import Substitution
from launcher.language.utilities import SomeSubstitutionsType, SomeSubstitutionsType_types_tuple

__all__ = [
    "Action",
    "Condition",
    "Event",
    "EventHandler",
    "InvalidLaunchFileError",
    "LaunchContext",
    "LaunchDescription",
    "LaunchDescriptionEntity",
    "LaunchDescriptionSource",
    "LaunchIntrospector",
    "LaunchService",
    "SomeEntitiesType",
    "SomeEntitiesType_types_tuple",
    "SomeSubstitutionsType",
    "SomeSubstitutionsType_types_tuple",
    "Substitution",
]

__getattr__ = refuse_unknown("launch", __all__)
