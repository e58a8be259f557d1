"""Parse functions of tags and substitutions, one module for each kind of class."""
