"""The fault matrix: what is left when processes of a run are killed with SIGKILL.

Each run is in namespaces of its own (processes, mounts, network): whatever it leaves is seen, and
ends with it.
"""
