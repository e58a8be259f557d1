"""Python nodes forked from a process that has imported what they need: docs/inside/warm.md.

`spawner` is offered each start of the driver, and is imported for the first Python node of a run;
what it does not take is spawned cold. In the launcher: `eligibility` says why a process is cold,
`preparing_process` is this side of the preparing process, `request` one start with its
descriptors.

In the preparing process: `preparing` is its script, `preparing_service` its loop; `preparation`
finds what to import, imports it and finds what is no good for a fork. `forking` makes a process,
`spare` one ahead of its start; `child` and `warm_program` make of it what an executed one would be.
`stack_answer` reports what its threads are doing, where py-spy cannot.

A request goes through a Unix socket with SCM_RIGHTS (`preparing_messages`): standard streams and a
`status` socket. The preparing process forks twice; the process in between exits before the answer,
so that the launcher, which adopts orphans, is the parent. Exit, leftovers and core dumps are
noticed as ever.

The new process waits on `status` until the launcher has its pidfd, and ends if the launcher does.
It closes `status` when its program begins: until then it is STARTING. Stopped meanwhile, the start
is withdrawn: closing `status` ends the process before its program. It leaves the loop of the
preparing process by returning, and runs its program from the last line of `preparing`, so that the
interpreter's own end follows: exit code, threads, `atexit`, SIGINT after a KeyboardInterrupt.

Timers of the launch file (`launcher.run.launch_timers`) that the interpreter requests together with
starts count from the first of these that is complete, after the preparation if one of them waits
for that.
"""
