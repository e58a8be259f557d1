"""`hosts sync`: brings the launcher, packages and their Python environment to other hosts.

`packages` finds what is to be brought and `tree` reads it; `wheels` chooses wheels for a host;
`session` talks to the program in `there/`, which is sent to the host and runs on its Python;
`fleet` does it for all hosts at once.
"""
