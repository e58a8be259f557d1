"""The launch language: entities with ROS 2's names, signatures and behaviour.

May import `base`, `posix`, `packages` and `output`. Entities are data until they are visited with
a `LaunchContext`. They do no I/O to start something: they send requests to the context's host
(`host.Host`), which the interpreter implements. Their meaning is in their own `visit`, `execute`
and `perform`, as in ROS 2, since other packages subclass them and call `super()`.

Doors:

* `frontends`: a Python, XML or YAML file becomes a `LaunchDescription`; `locate` finds the file
  that a command line names.
* `interpreter`: walks a description, and gives effects for events.
* `compat`: what `import launch` and `import launch_ros` find in a launch file: one table of names.
* `service`: LaunchService for scripts (`import launcher.api`). `testing`: what launch files load
  of launch_testing. `introspection`: a description as text.

Folders, one module per family of classes: `actions/`, `events/` (with their handlers),
`substitutions/`, `ros/` (launch_ros) and `logging/` (launch.logging). `diagnostics/` has the place
where an entity was created, mistakes, hints, and warnings about ROS 2's behaviour; what it finds
is reported with file and line.

A launch file reads `os.environ` itself while it is evaluated, and `Command` inherits it; it is
restored afterwards. Numbers such as `CONFORMANCE 1.30` refer to docs/inside/ros2-behaviour.md.
"""
