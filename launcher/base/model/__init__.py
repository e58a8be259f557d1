"""Plain data that the interpreter and its drivers exchange: specs, effects, events."""
