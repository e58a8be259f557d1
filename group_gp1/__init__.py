"""A small warehouse fleet: dispatcher, robots, monitor, and two nodes for looking in."""
