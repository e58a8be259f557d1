"""Results for people, for CI and for the next run, and the evidence."""
