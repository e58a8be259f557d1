"""A small warehouse fleet: dispatcher, robots, monitor, and two diagnostic nodes."""
