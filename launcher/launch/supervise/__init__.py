"""Supervision files: settings of processes, when they are ready, and which wait for others."""
