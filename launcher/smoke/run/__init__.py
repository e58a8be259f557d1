"""A smoke command, its runs, and the systems that they launch."""
