"""Substitutions (`launch.substitutions`)."""
