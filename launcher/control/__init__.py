"""The control socket of a run: server, protocol and client (docs/control.md)."""
