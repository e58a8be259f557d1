"""`pkg create`: makes packages of nodes and of interfaces that `build` and `test` take at once."""

PYTHON, CMAKE = BUILD_TYPES = ("ament_python", "ament_cmake")
