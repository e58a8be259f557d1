"""Transforms between frames, as tf2 has them, without tf2.

`arithmetic` computes with transforms, `frame_buffer` keeps those of the last seconds and looks up
others, `frame_tree` is what was received of each frame, and what is wrong with it; `tf_message`
reads serialized messages. `tf_echo`, `tf_monitor` and `static_transform` are the verbs of these
names. Only `tf_listener` needs a ROS node.
"""
