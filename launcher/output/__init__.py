"""From the output of processes to ours: whole lines, filtered and safe to show."""
