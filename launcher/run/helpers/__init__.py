"""Starts and stops the helper processes of a run: console, ROS agent, ROS bridge."""
