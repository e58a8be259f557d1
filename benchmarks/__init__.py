"""Benchmarks of the engine: `python -m benchmarks` measures and prints one table.

What is measured, and what the figures mean, is in docs/inside/benchmarks.md.
"""
