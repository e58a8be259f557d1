"""The engine of hosts with systemd: it supervises there, and this is the operator's side of it.

Nothing of the launcher stays on the host. `systemd_link` has the state machines of its units
(`unit_process`), which follow the journal, while systemd carries out restarts and stops.

* One connection has two sessions (`sessions`): a shell that is given scripts on its standard
  input, one after the other (`shell`, `scripts`), and one `journalctl -f`, read on from its last
  cursor after a lost link (`journal`, `journal_events`). Scripts do no harm if they are run twice:
  each start has a token.
* A start script of ours notes each start and `ExecStopPost=` each exit in the journal, with the
  invocation id of systemd: what is reported twice counts once. Every 3 s the states of the units
  are compared with what the journal has reported. `exits`: how a process ended; `unit_state`:
  what it is doing; `samples`: its resources; `host_facts`: whether the systemd of a host can be
  used.
* The journal looks up the unit of a line when it reads it, and a child that has written it may
  have ended. So streams whose unit is not known when they are opened (those of users, and those
  that are apart) begin with a line that names the process, which is not shown.
* `stop-after` is a separate unit that waits for the beats of the shell.
* `attach` (`run_manifest`, `found_runs`) asks for the states of the units and for the latest
  records, so that it is known whose lines come, before it follows the journal from the last lines
  on (`adoption`). Past is what the journal has from before the states were asked for; what is new
  is always shown.
* `unit_installer`: the units of `launch --enable`.
"""
