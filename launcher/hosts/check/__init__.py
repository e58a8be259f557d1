"""`hosts check`: tries every host at the same time, and says what is wrong and how to repair it.

`probe` is the program that every host gets, sent as source; `probe_session` talks to it, `survey`
has them all at the same time. `needs` is what the processes of a launch file need, `examine` the
whole check; `host_judges` and `pair_judges` go from facts to findings, which `check_report` shows.
"""
