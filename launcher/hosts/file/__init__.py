"""The hosts file: hosts, rules of placement, and what a host is to run.

`hosts_reader` reads it by the tables in `host_fields`, `discovery_field` and `ssh_options`, of
which `schema` makes the JSON Schema; `hosts_model` has hosts and rules, `option_changes` the file
as options change it. `pattern` and `placement`: which process a rule means, and where each runs.

`order` is what a host is to run, with `references` in place of the operator's paths, and
`order_json` its form on the wire. What a host makes of it: `resolution` in the agent, and without
one `order_words` (the words of a unit) and `run_order` (the program of a unit that resolves them
there).
"""
