"""`test`: runs the tests of packages of a workspace, each package in a ROS domain of its own."""
