"""The parts of the page of an incident, each a function that returns `Markup`."""
