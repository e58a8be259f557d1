"""A launch with the shape of large public ones: Autoware starts 144 processes and 84 components."""

from benchmarks.large.bench import large

__all__ = ["large"]
