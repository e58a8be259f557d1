"""A fault, its life, and the incident that it belongs to; without I/O."""
