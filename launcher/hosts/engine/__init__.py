"""Processes on other hosts: the operator's side of their engines.

`link` is the interface of an engine, made by `host_links`; `fleet` has the links of a run. `driver`
is the process driver, `replica` the machine of a process elsewhere, `remote_host` a host as the run
sees it, `reports` its events as JSON. `hosts_backlog` holds back what hosts have reported of the
past at `attach`, to show it in order of time. `host_links` lets the host decide on its engine where
the hosts file does not.

* A random delay of a restart would differ: each event carries the time that is left to the
  deadline of the original. A TICK comes from the host; a replica has no timer.
* A start that was requested and not reported yet shows as STARTING, so that the run does not end
  meanwhile. Everything else shows only when the host has reported it.
* Times are those of the launcher's clock, by an offset that stays the same as long as the
  processes live: decisions by differences of times are the same on both sides.

`engine: ssh` is `agent_link`: one `launcher agent` per host by `ssh -T` (`SshTransport`), not a
session per process, of which sshd allows 10. Both directions carry `frames`: length, kind, number,
time of the sender, payload. A frame with a number is kept by its sender until it is acknowledged
(`outbox`), and sent again on the next connection (`frame_channel`): 4 MiB while connected, 32 MiB
of output while not; events are never dropped. A beat each second, or each quarter of a `stop-after`
below 4 s, gives the difference of the clocks; after 3 s of silence each side takes the other one
for unreachable, and after 6 s the launcher connects again with `agent --resume`.

`engine: systemd` is `systemd/`. Tests run hosts in the launcher's process
(tests/support/loopback).
"""
