"""The expectation file: its grammar, its schema, and what it contains."""
