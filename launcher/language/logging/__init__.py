"""`launch.logging`: its configuration and loggers, and its handlers."""
