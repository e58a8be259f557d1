"""Helpers for tests that run real nodes."""
