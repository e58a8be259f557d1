"""Processes on other hosts: the operator's side of their engines."""
