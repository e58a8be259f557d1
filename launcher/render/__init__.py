"""Renderings of plans."""
