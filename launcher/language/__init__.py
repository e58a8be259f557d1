"""The launch language: entities with the names, signatures and meaning that ROS 2 gives them.

Entities are data until they are visited with a `LaunchContext`. They never touch the operating
system to start something: what they want is asked of the context's host (`context.Host`), which
the interpreter implements. Launch files reach the classes under ROS 2's names through
`launcher.language.compat`.
"""
