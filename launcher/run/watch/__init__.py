"""Watches the files that processes have loaded; its own process, `python -m launcher.run.watch`."""
