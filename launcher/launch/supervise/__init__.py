"""Supervision files: settings of processes, when they are ready, and which wait for others.

`file` reads one by the tables in `fields` and `ready_fields`; the JSON Schema is made of these.
`circles` finds processes that wait for each other.
"""
