"""Files for other supervisors, made from a plan: systemd, Kubernetes, Compose, Podman.

May import the core and `hosts`. Does no I/O apart from reading parameter files and writing the
result, and starts nothing.

Doors: `verbs/export`, and `verbs/enable`, which installs units on hosts for `launch --enable`.
`export_settings` is the table of what can be written.

* `exported_system` makes processes of a plan (`export_model`): `exported_command` are command lines
  without paths of the operator's machine (`process_command`: with their programs),
  `exported_variables` says which variables may be secret, `discovery_variables` which ones hosts
  need, `unit_names` what systemd and Kubernetes accept.
* `unsupported` finds what a launch file and its supervision file do that no such file can do; each
  export lists them.
* `systemd`, `kubernetes`, `compose` and `quadlet` write for one engine each; `image` is the
  Containerfile with the launcher and the packages of the plan, `readme` the commands to use it
  all. `yaml_text` writes YAML that is the same each time.
* `folder` is the output: written again as a whole, and nothing of others is overwritten.
"""
