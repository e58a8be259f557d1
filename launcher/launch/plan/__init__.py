"""Plans and arguments of launch files as text and JSON."""
