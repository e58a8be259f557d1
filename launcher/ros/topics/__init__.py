"""What the verb `topic` does: listing, echo, publishing, statistics.

`listener` receives, `fitted` and `qos` choose settings that fit the publishers, `raw`
takes bytes without decoding; `unmatched` says who does not get messages. `topic_history`: the depth
of queues; `clock`: times of a simulation.
"""
