"""Substitutions, by what they look at: texts, configurations, environment, files, programs."""
