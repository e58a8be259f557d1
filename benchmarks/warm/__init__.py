"""Benchmarks of real nodes in a private ROS domain: warm starts, discovery, many robots.

A benchmark of the group `warm` is a function of `runs`, and a name that begins with `warm-` in
`benchmarks.__main__`.
"""
