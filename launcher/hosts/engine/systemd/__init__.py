"""The engine of hosts with systemd: it supervises there, and this is the operator's side of it."""
