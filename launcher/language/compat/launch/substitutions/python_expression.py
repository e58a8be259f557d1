"""`launch.substitutions.python_expression`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.python import PythonExpression

__all__ = ["PythonExpression"]

__getattr__ = refuse_unknown("launch.substitutions.python_expression", __all__)
