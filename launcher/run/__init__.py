"""Runs a launch file with real processes, in one thread with one event loop.

`machine` and `shutdown_machine` decide without I/O; `supervisor` composes the parts that act.
"""
