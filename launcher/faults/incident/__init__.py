"""`incident`: one HTML file about one incident of a run, which opens without a network.

Doors: `verb` (`incident`); `document` reads the JSON of an incident, and `page.render` makes the
HTML of it.

* `document`: the fields of an incident, with what was wrong about the file.
* `run_folder` finds a run, `stories` lists its incidents and snapshots, and `from_snapshot` makes
  the document of a snapshot of the flight recorder.
* `redaction` removes secrets, `markup` escapes texts.
* `page` has the parts in their order; each is a module that returns `Markup`.

Nothing of an incident becomes markup: `markup.tag` escapes every text that is not `Markup`, and
drawings of Graphviz are read and written again with known elements only (`graph_drawing`).
"""
