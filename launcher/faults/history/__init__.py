"""The faults of all runs, in `faults.sqlite` beside the folders of the runs.

`writing` is for the watcher of a run, `reading` and `listing` for `faults --all-runs`. `database`
is the file; `versions` is what was run: the hash of the launch files, and their commit.
"""
