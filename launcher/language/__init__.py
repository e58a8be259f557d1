"""The launch language: entities with ROS 2's names, signatures and behaviour.

Entities are data until they are visited with a `LaunchContext`. They do no I/O to start something:
they send requests to the context's host (`language.host.Host`), which the interpreter implements.
Launch files import the classes under ROS 2's names through `launcher.language.compat`.
"""
