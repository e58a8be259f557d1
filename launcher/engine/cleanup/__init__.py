"""What makes sure that nothing of a run outlives it."""
