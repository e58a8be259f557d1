"""Processes that accompany a run without being part of it."""
