"""Why a fault is there: rules that can be read, and which faults follow from another.

`rules` and `machine_rules` are pure functions (fault, story) -> cause, asked in the order of RULES:
what explains more comes first. `grouping` puts faults with one cause into one incident.
"""
