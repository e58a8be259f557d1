"""`hosts sync`: brings the launcher, packages and their Python environment to other hosts.

`packages` finds what is to be brought and `tree` reads it; `wheels` chooses wheels for a host;
`sync_session` talks to the program in `on_host/`, which is sent to the host and runs on its Python;
`fleet_sync` does it for all hosts at once.
"""
