"""`test`: runs the tests of packages of a workspace, each package in a separate ROS domain.

`package_jobs` are commands, one or more for a package; `job_runner` runs them as processes, by the
event loop, watchdog and sweep of the launcher; `package_results` reads JUnit files,
`package_report` prints, and writes what GitHub Actions shows.
"""
