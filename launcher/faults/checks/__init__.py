"""Whether expectations hold now: a check for each kind, and those of every watched run.

`live_checks` is the table, `check` what they have in common. `present` judges the state of this
moment with the judges of smoke; `arriving` judges what has just come (lines, messages); `traffic`
rates, gaps and latencies; `usage` memory and CPU; `implied` is what every watched run expects.
"""
