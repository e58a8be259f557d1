"""`pkg create`: makes packages of nodes and of interfaces that `build` and `test` take at once."""
