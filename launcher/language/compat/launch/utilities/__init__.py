"""`launch.utilities`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "create_future": "launcher.language.utilities",
    "ensure_argument_type": "launcher.language.utilities",
    "get_signal_name": "launcher.language.utilities",
    "is_a": "launcher.language.utilities",
    "is_a_subclass": "launcher.language.utilities",
    "isclassinstance": "launcher.language.utilities",
    "normalize_to_list_of_entities": "launcher.language.utilities",
    "normalize_to_list_of_substitutions": "launcher.language.utilities",
    "perform_substitutions": "launcher.language.utilities",
    "visit_all_entities_and_collect_futures": "launcher.language.utilities",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
