"""Control: a running run's socket, and what can be said over it (docs/control.md)."""
