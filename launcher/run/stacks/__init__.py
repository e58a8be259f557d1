"""What the threads of a running process are doing."""
