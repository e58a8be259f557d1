"""`hosts check`: tries every host at the same time, and says what is wrong and how to repair it."""
