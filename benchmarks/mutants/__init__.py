"""Faults in the sources of the fleet, and the expectations of the smoke files that see them."""

from benchmarks.mutants.runs import mutants

__all__ = ["mutants"]
