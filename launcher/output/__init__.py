"""From the output of processes to ours: whole lines, filtered and safe to show.

May import `base`, `posix` and `packages`. It has no processes: `launcher.run.output` connects the
two.

The path of a line has no return: bytes go from `os.read` to the terminal in whole blocks, by one
search for the last newline and one `replace` for the prefixes. Only filters, formats and handlers
split a block. A slow terminal stops the reading, and full pipes stop the writers.

Doors:

* `lines`: splits output into whole lines, and removes control characters before they are shown.
* `filters`: which lines of a process are shown; log files and memory get all. A process without a
  filter costs one comparison per block. Searches by expressions of users have a limit of CPU time.
* `line_format`: `compact`, or a user's template; `tracebacks`: kept together, and shortened where
  a stop was ordinary; `escapes`: control characters removed for terminals.
* `stdout`: lines with prefixes and colours, written to our standard output by an `output_queue`,
  which does not block. `backlog`: at the end of a run, waits for a slow reader, or drops visibly.

Folder: `logs/` is the folder of a run on disk: `run_directory`, its files (`rotating_file`,
`event_log`) and the removal of `old_runs`.
"""
