"""MCAP (https://mcap.dev/spec): the files in which bags are recorded.

`file` reads the messages of a bag's file, `output` writes one. `records` reads records within
bounds, `summary` the index at the end. `scan` reads all of a file and finds what is damaged or was
left by a killed recorder, `repair` makes it whole.
"""
