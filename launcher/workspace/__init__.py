"""Verbs that build and test the packages of a colcon workspace."""
