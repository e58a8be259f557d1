"""Files for other supervisors, made from a plan: systemd, Kubernetes, Compose, Podman.

May import the core and `hosts`. Does no I/O apart from reading parameter files and writing the
result, and starts nothing.

Doors: `verbs/export`, and `verbs/enable`, which installs units on hosts for `launch --enable`.
`engines` is the table of what can be written.

* `system` makes processes of a plan (`model`): `words` are command lines without paths of the
  operator's machine (`command`: with their programs), `environment` says which variables may be
  secret, `discovery` which ones hosts need, `names` what systemd and Kubernetes accept.
* `gaps` finds what a launch file and its supervision file do that no such file can do; each export
  lists them.
* `systemd`, `kubernetes`, `compose` and `quadlet` write for one engine each; `image` is the
  Containerfile with the launcher and the packages of the plan, `readme` the commands to use it
  all. `yaml_text` writes YAML that is the same each time.
* `folder` is the output: written again as a whole, and nothing of others is overwritten.
"""
