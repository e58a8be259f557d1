"""The fault matrix: what is left when processes of a run are killed with SIGKILL.

Each run is in separate namespaces (processes, mounts, network): whatever it leaves is seen, and
ends with it.
"""
