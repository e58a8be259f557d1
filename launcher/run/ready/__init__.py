"""When processes are ready, and starts that wait for it."""
