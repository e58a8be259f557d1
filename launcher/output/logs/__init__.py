"""The log folder of a run, and the messages and events that are written to it."""
