"""Re-exports of `launch.launch_description_sources`."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.sources import PythonLaunchDescriptionSource

__all__ = ["PythonLaunchDescriptionSource"]

__getattr__ = refuse_unknown("launch.launch_description_sources", __all__)
