"""What is measured once a second: resources, budgets, shared memory."""
