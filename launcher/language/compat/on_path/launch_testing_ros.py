"""Stands in for a package that is not installed; `on_path_modules` says how."""

from launcher.language.compat.on_path_modules import provide

provide(__name__)
