"""Hooks of MkDocs (mkdocs.yml): documents that are not in docs/, and links to them.

On GitHub a page links to `../../CONTRIBUTING.md` or to a file of the code. In the site the first is
a page, and the second leads to the repository, if its address is known, or is no link.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
# Document of the repository -> page of the site.
ADDED = {
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "group_gp1/README.md": "guides/course.md",
}
FOREIGN = re.compile(
    r"<(?:script|img|iframe)[^>]*\ssrc=\"https?:[^>]*>|<link[^>]*stylesheet[^>]*https?:[^>]*>"
)
LINK = re.compile(r"\[(?P<text>[^\]]*)\]\((?P<target>[^)#\s]+)(?P<anchor>#[^)]*)?\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the documents that are outside of docs/."""
    for source, uri in ADDED.items():
        files.append(File.generated(config, uri, abs_src_path=str(ROOT / source)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Lead the links of a page to where their targets are in the site."""
    uri = page.file.src_uri
    places = {uri: source for source, uri in ADDED.items()}
    source = places.get(uri, f"docs/{uri}")

    def replace(link: re.Match[str]) -> str:
        text, target, anchor = link["text"], link["target"], link["anchor"] or ""
        if ":" in target:
            return link[0]
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        if path.startswith("docs/") or path in ADDED:
            there = ADDED.get(path, path.removeprefix("docs/"))
            return f"[{text}]({posixpath.relpath(there, posixpath.dirname(uri))}{anchor})"
        if not (ROOT / path).exists():
            return link[0]  # reported by MkDocs
        return f"[{text}]({config.repo_url}/blob/HEAD/{path}{anchor})" if config.repo_url else text

    return LINK.sub(replace, markdown)


def on_post_page(output: str, page: Page, config: MkDocsConfig) -> None:
    """Refuse a page that loads something from another server."""
    if found := FOREIGN.search(output):
        raise PluginError(f"{page.file.src_uri} loads from another server: {found[0]}")
