"""The reader of the streams of processes, and what of them is on the screen.

stdout and stderr share one descriptor if both go to the same places and no handler distinguishes
them: that keeps the order of writing, which two pipes lose. Bytes go from `os.read` to the terminal
in whole blocks: one search for the last newline, one `replace` for the prefixes. A slow terminal
stops the reading, and full pipes stop the writers.

What is left in a pipe is read before an exit is reported. If a descendant keeps the pipe open, the
reader keeps it, too, to its end or that of the run, also beside the next life of the process, but
without effect on what is ready. A process without a filter costs one comparison per block.
"""
