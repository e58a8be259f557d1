"""Supervision files: settings of processes, when they are ready, and which wait for others.

`supervise_reader` reads one by the tables in `supervise_fields`, `ready_fields` and `fault_fields`;
the JSON Schema is made of these. `circles` finds processes that wait for each other.
"""
