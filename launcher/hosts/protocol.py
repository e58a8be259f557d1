"""The version of what a launcher and the agent on a host say to each other (`engine/hosts/frames`).

Another one on the other side is an error.
"""

PROTOCOL = 1
