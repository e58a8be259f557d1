"""Start, stop and restart of a process: `machine` decides, without I/O; `process_driver` acts.

`machine_events` are what goes in and out of the machine, also between hosts. `process` is what a
run has of one process, `process_reports` what is logged about it.
"""
