"""What all rooms use, and what uses none of them: text, errors, documents, the grammar of verbs.

Imports nothing of the launcher outside of this room.

Doors:

* `errors`: `LauncherError` and its kinds, with place, hint and exit code; the table of exit codes.
* `command_line`: `Command`, the grammar of all command lines: tables of options (`option`), and the
  one parser that reads words by them. `command_front` has the options in front of a verb,
  `command_help` what `--help` prints; docs/reference/command-line.md is made from the same tables.
* `verb_table`: the module of each verb, imported when the verb is used. With `launcher.run.parts`,
  `launcher.run.part_verbs` and `launcher.run.helpers.helper_programs`, the only place where the
  core names the wings.
* `text`: suggestions for misspelt words, counts, escaped control characters. `synonyms`: what
  verbs and options of other programs mean here; only mistakes need it. `program`: the name in
  usages, `launcher` or `python -m launcher`.
* `strict_json`: JSON is written and read nowhere else. `text_file`: files of users, of bounded
  size, and pointers of Git LFS in their place. `xml_tree`: XML with the place of each tag.
  `yaml_bounds`: YAML of others, within bounds; `yaml_dumper`: the writer of YAML.
* `github`: annotations and summaries of GitHub Actions.

Folders: `model/` is the plain data that the interpreter and its drivers exchange; `document/`
reads YAML files that users write, and makes their JSON Schema.

What a launch imports on the way to its first process avoids `typing`, `pathlib` and `dataclasses`,
which take milliseconds: names for types are imported below `TYPE_CHECKING = False`, which type
checkers take for true.
"""
