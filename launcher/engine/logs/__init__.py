"""The files of a run, and the lines and events that go there."""
