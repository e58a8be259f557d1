"""`hosts sync`: brings the launcher, packages and their Python environment to other hosts.

`synced_packages` finds what is to be brought, `local_packages` packages that pip has installed from
a folder or file, which no index has for the hosts; `release_tree` lists the files of a release;
`pinned_list` are those of its Python environment, `wheels` chooses wheels for a host, `natives`
says what the host can load; `release_python` is the interpreter of a release. `sync_session` talks
to the program in `on_host/`, which is sent to the host as source and runs on its Python;
`host_sync` brings one host up to date, `fleet_sync` all at once.
"""
