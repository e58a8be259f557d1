"""The flight recorder of a run (`--record`): its options, its process, and the verb `snapshot`."""
