"""YAML documents that users write: expectations, hosts files, supervision files.

`document_reader` collects all mistakes of a document with their lines (`source_location`). `fields`
and `quantities` are types of entries; each also returns its part of the JSON Schema, so that what
is read and what an editor suggests come from one table.
"""
