"""Builds the packages of a workspace: colcon, in an environment of wheels.

`builder` is the order of steps: `build_place` (which workspace), `lock` (one build at a time),
`records` (what a package was built from, and what has changed), `preflight` (which packages are
built), `build_progress` and `status_line` (what is shown meanwhile), `build_report` (the end).

* `sources/` finds and reads packages without running them; `checks/` finds their mistakes before
  anything is compiled.
* `toolchain/` has the compiler and the environment of colcon, and CMake files that correct the
  imported targets of the wheels and make libraries relocatable; `extra` is the extra of pip that
  brings it.
* `colcon/` runs colcon in a separate process, which passes on its events and kills its compilers
  if the launcher dies; `explain/` says why a package failed.
* `create/` has the templates of `pkg create`, `wheel/` the verb `wheel`.
"""
