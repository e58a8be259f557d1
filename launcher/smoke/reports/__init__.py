"""Reports: the results of smoke runs for people, for CI, and for the next run."""
