"""Recording and playing bags: what of `bag` needs ROS.

`record_run` and `player` are the verbs: `recorder` subscribes and `sinks` take what it gets;
`publishers` publish what `read_ahead` has ready, at the times of a clock, steered by
`keys_and_status`, as recording is; `bag_qos` chooses the settings of both. `recorded_calls` sends
calls of services and actions again. `record_services` and `player_services` are those of rosbag2
(`control_services`), `static_topics` reads what is recorded from the start.

`flight` is the flight recorder, a helper process of a run: it keeps the last messages and writes
them when it is asked (docs/reference/bags.md), also if the launcher was killed, which it outlives
for this.
"""
