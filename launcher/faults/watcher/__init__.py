"""The helper process of a watched run: `python -m launcher.faults.watcher SETTINGS`.

SETTINGS is JSON (`WatchSettings`). It reads lines of JSON on stdin: first `{"do": "begin",
"written_s"}`, when an earlier watcher of this run has reported last (in seconds since 1970, or
null), then `{"do": "acknowledge", "fault", "id", ...}` (or `mute`, `unmute`), `{"do": "stop"}` when
the run begins to stop, and `{"do": "end"}`; the end of stdin without `end` is the death of the
launcher. It writes lines to stdout: `{"fault": ..., "change": ...}` for each change,
`{"left": [...]}`: what is left to smoke, `{"names": [...]}`: which faults there may be,
`{"note": TEXT}` for the launcher's log, `{"mistake": TEXT}` if the expectations cannot be read, and
`{"alive": true}` every two seconds; the answer to a request has its `id`, and `error` if it is
refused.

* `watching` has observations taken and judged, several times a second. `fault_table` is what comes
  of that: faults, their causes and incidents.
* `observations` takes them from threads, `story` keeps those of the last minutes.
* `machine_facts` reads the machine: pressure, disk, clock, whether processes are suspended.
* `topic_watch` counts messages, by the probe; `parameter_watch` asks for parameters.
* `handover` leaves out what an earlier watcher has judged.
* `incident_files` writes incidents into the folder of the run.
"""
