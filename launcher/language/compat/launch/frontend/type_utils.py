"""Re-exports of `launch.frontend.type_utils`."""

from launcher.frontends.types import get_data_type_from_identifier
from launcher.frontends.types import is_entity_list as check_is_list_entity
from launcher.language.compat.names import refuse_unknown

__all__ = ["check_is_list_entity", "get_data_type_from_identifier"]

__getattr__ = refuse_unknown("launch.frontend.type_utils", __all__)
