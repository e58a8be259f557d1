"""The node classes, one a module; the entry points that run them are in the folder above."""
