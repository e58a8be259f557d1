"""`bag compare`, and what is typical of a topic."""
