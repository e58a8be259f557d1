"""Python nodes forked from a process that has imported what they need: docs/warm.md.

`spawner` is offered each start of the driver, and is imported for the first Python node of a run;
what it does not take is spawned cold. In the launcher: `eligibility` says why a process is cold,
`preparing_process` is this side of the preparing process, `request` one start with its
descriptors.

In the preparing process: `preparing` is its script, `service` its loop; `scan` finds what to
import, `preparation` imports it and finds what is no good for a fork, `freshness` what has changed
on disk since, `heap` keeps its pages shared. `forking` and `tracing` make a process; `child`,
`title` and `program` make of it what an executed one would be. `stack_answer` reports what its
threads are doing, where py-spy cannot.

A request goes through a Unix socket with SCM_RIGHTS (`wire`).
"""
