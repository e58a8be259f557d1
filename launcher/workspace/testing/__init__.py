"""`test`: runs the tests of packages of a workspace, each package in a separate ROS domain.

`jobs` are commands, one or more for a package; `runner` runs them as processes, by the event loop,
watchdog and sweep of the launcher; `results` reads JUnit files, `report` prints, and writes what
GitHub Actions shows.
"""
