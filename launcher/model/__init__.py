"""What the interpreter and its drivers say to each other: specs, effects, events. Data only."""
