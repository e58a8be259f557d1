"""The expectation file: its grammar, its schema and its loader."""
