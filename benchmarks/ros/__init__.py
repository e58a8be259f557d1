"""Benchmarks of the verbs that talk to nodes."""
