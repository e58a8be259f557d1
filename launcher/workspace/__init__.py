"""`build`, `test`, `wheel`, `pkg` and `env`: verbs for the packages of a colcon workspace.

Where a workspace is and what it sets is core: `launcher.packages.workspace`, `.environment`. May
import the core and `doctor`.

Doors: `verbs/`. `doctor` also uses `building.records`, `sources`, `build_place` and `toolchain` to
say what is stale, `hosts sync` `building.build_place` for what is not built.

* `building/`: `build`, `wheel` and `pkg create`.
* `testing/`: `test`.
"""
