"""Measurements once a second: resources, budgets, shared memory.

`housekeeping` is the second; `resources` are the samples, `budgets` (`budget_parser`: their
grammar) end or warn of what uses more. `oom`: whether the kernel has killed a process;
`shared_memory`: what dead participants leave, `ledger`: which of it belongs to the run;
`responsiveness`: whether nodes answer.
"""
