"""Several nodes of a launch file in one process, for `--compose`."""
