"""`launcher agent`: the process on a host that runs what a launcher elsewhere requests.

It is our engine with watchdog, control group and sweep: `workload` has the processes, by the parts
of `launcher.run`; all are started cold. `forwarder` sends output in blocks, and the log of
`workload` what the launcher would print. `host_agent` has the connection, and decides whether
the processes run on without it.

* The end of the input is a lost link, not an order. `stop-after` counts from the last frame of the
  launcher. Without processes and launcher the agent ends after 30 s, or 10 minutes if it keeps; at
  once if the launcher has not counted it as ready yet.
* `agent --resume` passes its standard streams to the agent through a socket in a private folder
  (`takeover`). Each side says which frame it has last, and the other sends what comes after.
* Output that waits for a link slower than the processor is compressed (`engine/compression`), if
  the launcher's OPEN `accepts` that.
* Bytes that are no frames end the agent in order: it stops the processes, says why, and exits.
* Values of variables and the contents of files are only in frames: not in command lines, logs or
  messages. Files of orders are in a private folder until the end.
"""
