"""`test`: runs the tests of packages of a workspace, each package in a separate ROS domain.

`test_jobs` are commands, one or more for a package; `job_runner` runs them as processes, by the
event loop, watchdog and sweep of the launcher; `test_results` reads JUnit files, `test_report`
prints, and writes what GitHub Actions shows.
"""
