"""`doctor`: finds what makes ROS runs fail on this machine.

`collect` gathers facts (the only I/O), `checks` judge them, `repairs` fix what can be fixed.
"""
