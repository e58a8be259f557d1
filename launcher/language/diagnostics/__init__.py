"""Errors, hints and warnings about launch files, with file and line."""
