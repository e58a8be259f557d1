"""Watches the files that processes have loaded; its own process, `python -m launcher.run.watch`.

`programs` finds the files, `folders` waits for changes, `settling` for their end, `contents`
compares, `checks` compiles, `watched` says what a change means. The supervisor's side is
`launcher.run.helpers.file_watcher`, for `launcher.run.watching`.
"""
