"""`bag convert`: bags into new ones, and into tables."""
