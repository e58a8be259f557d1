"""Actions, by what they act on: arguments and scopes, processes, time, events, other files."""
