"""What is wrong or surprising in a launch file, and where."""
