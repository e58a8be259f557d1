"""Events, and the handlers that react to them."""
