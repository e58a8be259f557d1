"""Measurements once a second: resources, budgets, shared memory."""
