"""Injected faults: what a system does when one of its processes, or the machine, fails.

`grammar` reads the words of an injection; `injections` is the part of a run that begins and ends
them, `effects` what they do, by the programs `stress` (time, CPU, memory, disk) and `topic_proxy`
(messages). `chaos_plan` reads a seeded plan of them, which `chaos` carries out.
"""
