"""The verb `reload`: carries out what a new evaluation of the launch file means for a run.

`launcher.launch.reloading` evaluates it, in the process of the run with the environment of the
call. The new interpreter is brought to the moment of the run: it gets the starts and exits of the
processes that it shares with it, and timers whose time has passed fire. What is left over is a
`Reload`. Until it is adopted, nothing has changed; then the old interpreter gets no event any more.
"""
