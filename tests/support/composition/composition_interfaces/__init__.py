"""A stand-in for the package that has no wheel, for processes with this folder in PYTHONPATH."""
