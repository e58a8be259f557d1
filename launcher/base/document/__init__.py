"""YAML documents that users write: where each entry stands, and types of entries."""
