"""Stops what outlives its process or the launcher: leftovers, the watchdog."""
