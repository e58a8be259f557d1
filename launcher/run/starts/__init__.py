"""Starts of processes: stages between `core_driver`, which adds new ones, and `run.Spawner`.

`pacing` holds starts back until their turn, `launcher.run.ready.gate` until other processes are
ready, and `warm_starts` offers them to `launcher.run.warm`. A process that a stage holds back is
STARTING.

A child begins with every signal at its default, and none blocked: by `posix_spawn`, or between fork
and exec where `subprocess` starts it. It has the soft limit of open files that the launcher was
started with. One with limits (`--nice`, `--cpus`, `--limit`) is STARTING until a small interpreter
in between (`launcher.posix.limits_exec`) has set them and exec'd the program, or has reported what
was refused.
"""
