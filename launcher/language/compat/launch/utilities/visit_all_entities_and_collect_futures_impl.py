"""`launch.utilities.visit_all_entities_and_collect_futures_impl`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import visit_all_entities_and_collect_futures

__all__ = ["visit_all_entities_and_collect_futures"]

__getattr__ = refuse_unknown(
    "launch.utilities.visit_all_entities_and_collect_futures_impl", __all__
)
