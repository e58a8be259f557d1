"""Transforms between frames, as tf2 has them, without tf2.

`arithmetic` computes with transforms, `frame_buffer` keeps those of the last seconds and looks up
others, `frame_tree` is what is known of each frame, and what is wrong with it; all without ROS.
"""
