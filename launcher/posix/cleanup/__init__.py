"""Stops what outlives its process or the launcher: leftovers, the watchdog."""

RUN_ID_VARIABLE = "LAUNCHER_RUN_ID"  # in the environment of everything that a run starts
