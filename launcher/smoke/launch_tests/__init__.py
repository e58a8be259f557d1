"""Tests of launch files as ROS 2 has them: launch_testing, launch_pytest, launch_testing_ros.

The modules that tests import, `launch_testing.asserts` and so on, are made
from the table `launcher.language.compat.launch_test_table`, which names the modules here; what
launch files, too, load of launch_testing is `launcher.language.testing`. Installed packages of
ROS 2 go first.

Doors: `verb` (`launch-test`, and the program `launch_test`); `pytest_plugin`.

* `loading`, `running`, `results`, `junit`: a test of launch_testing, its runs, and their report.
* `observations`, `process_lookup`, `text_matching`, `asserts`, `process_proxy`: what tests use.
* `test_modules`, `file_faults`: how pytest collects tests of launch_testing, and what files raise.
* `launch_fixtures`, `launch_items`, `process_waits`: launch_pytest.
* `ros_tools`, and `launcher.ros.topics.test_nodes`: launch_testing_ros.
"""
