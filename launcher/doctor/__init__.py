"""The doctor: what on this machine makes ROS runs fail, and what to do about it.

`collect` looks (the only place that does), `checks` judge what was seen, `repairs` mend.
"""
