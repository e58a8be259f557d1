"""The supervisor: real processes, real time, one thread, one loop.

`machine` decides (pure), `spawn` and `sinks` touch the world, `supervisor` connects them.
"""
