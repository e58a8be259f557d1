"""Requests of users for processes, and their results.

Each process has a `request_queue`, a state machine: it decides in which order the requests of all
clients are carried out, which of them share a start, and what each is answered; a client that goes
withdraws what has not begun. `process_control` and `process_signals` carry the requests out. A
process that a user has stopped is *held*: the interpreter treats the run as busy, since the process
may be started again. `process_selection` finds processes by their names, `result_sentences` makes
sentences of results.
"""
