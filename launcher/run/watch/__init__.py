"""Watches the files that processes have loaded; its own process, `python -m launcher.run.watch`.

`programs` finds the files, `folders` waits for changes and for their end, `checks` compares and
compiles, `watched` says what a change means. The supervisor's side is `watching`.
"""
