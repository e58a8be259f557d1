"""`launch`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Action": "launcher.language.action",
    "Condition": "launcher.language.condition",
    "Event": "launcher.language.event",
    "EventHandler": "launcher.language.event_handler",
    "InvalidLaunchFileError": "launcher.language.sources",
    "LaunchContext": "launcher.language.context",
    "LaunchDescription": "launcher.language.description",
    "LaunchDescriptionEntity": "launcher.language.entity",
    "LaunchDescriptionSource": "launcher.language.sources",
    "LaunchIntrospector": "launcher.language.introspection",
    "LaunchService": "launcher.language.service",
    "SomeEntitiesType": "launcher.language.some_types",
    "SomeEntitiesType_types_tuple": "launcher.language.some_types",
    "SomeSubstitutionsType": "launcher.language.some_types",
    "SomeSubstitutionsType_types_tuple": "launcher.language.utilities",
    "Substitution": "launcher.language.substitution",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
