"""Write a file of expectations from what healthy runs showed."""
