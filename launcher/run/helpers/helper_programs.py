"""The programs of helper processes that have a ROS node, for `python -m`."""

AGENT = "launcher.ros.helpers.agent"
LOGGER_LEVELS = "launcher.ros.helpers.logger_levels"
NAMESAKES = "launcher.ros.helpers.namesakes"
PARAMETER_CHECK = "launcher.ros.helpers.parameter_check"
READY = "launcher.ros.ready"
RESPONSIVENESS = "launcher.ros.helpers.responsiveness"
