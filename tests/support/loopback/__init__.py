"""Hosts of a run in its own process: real processes, and a link that can be cut."""
