"""Python nodes forked from a process that has imported what they need: docs/warm.md."""
