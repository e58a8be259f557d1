"""Faults that are made on purpose in a watched run: which are found, how soon, and why.

`python -m benchmarks injected-faults` tries each kind with some seeds; `python -m
benchmarks.watched --seeds 10` prints the whole table (half an hour). `python -m benchmarks
watching` is what watching 100 topics takes.
"""
