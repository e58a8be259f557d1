"""What the threads of a running process are doing.

`stacks` asks all sources and puts their answers together: py-spy (`py_spy`), the node itself
(`warm_stacks`) where py-spy may not look, and the kernel. `dump` is the result as data and as
lines.
"""
