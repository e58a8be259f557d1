"""Why a fault is there: rules that can be read, and which faults follow from another.

`rules` are pure functions (fault, story) -> cause, in the order in which they are asked: what
explains more comes first. `grouping` puts faults with one cause into one incident.
"""
