"""Builds the packages of a workspace: colcon, in an environment of wheels."""
