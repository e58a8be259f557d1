"""`launch.utilities`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import (
    create_future,
    ensure_argument_type,
    get_signal_name,
    is_a,
    is_a_subclass,
    isclassinstance,
    normalize_to_list_of_entities,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    visit_all_entities_and_collect_futures,
)

__all__ = [
    "create_future",
    "ensure_argument_type",
    "get_signal_name",
    "is_a",
    "is_a_subclass",
    "isclassinstance",
    "normalize_to_list_of_entities",
    "normalize_to_list_of_substitutions",
    "perform_substitutions",
    "visit_all_entities_and_collect_futures",
]

__getattr__ = refuse_unknown("launch.utilities", __all__)
