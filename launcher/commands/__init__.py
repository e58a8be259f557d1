"""The verbs of the command line, one module each: `main(words) -> exit code`."""
