"""Judges: pure functions (expectation, facts) -> verdict, one for each kind of expectation."""
