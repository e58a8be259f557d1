"""The colours of the page: texts are readable on each ground, in light and dark."""

from __future__ import annotations

import re

import pytest

from launcher.web.assets import PAGE

TEXTS = ["text", "muted", "accent", "good", "warn", "bad", "idle", *(f"sgr-{i}" for i in range(8))]
GROUNDS = ["ground", "surface", "row-hover", "row-chosen", "row-current"]
THEMES = [":root", "body.body--dark"]


def colours(theme: str) -> dict[str, str]:
    styles = "".join((PAGE / "styles" / f"{name}.css").read_text() for name in ("page", "log"))
    blocks = re.findall(rf"^{re.escape(theme)} \{{(.*?)^\}}", styles, re.MULTILINE | re.DOTALL)
    return dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", "".join(blocks)))


def contrast(one: str, other: str) -> float:
    """As WCAG 2 defines it."""

    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        red, green, blue = (
            c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts
        )
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("theme", THEMES)
def test_texts_have_enough_contrast(theme: str):
    found = colours(theme)
    weak = {
        (text, ground): round(contrast(found[text], found[ground]), 2)
        for text in TEXTS
        for ground in GROUNDS
        if contrast(found[text], found[ground]) < 4.5
    }
    assert not weak


@pytest.mark.parametrize("theme", THEMES)
def test_fields_can_be_seen(theme: str):
    found = colours(theme)
    assert all(contrast(found["edge"], found[one]) >= 3 for one in ("ground", "surface"))


def test_the_colours_of_white_and_black():
    assert contrast("#ffffff", "#000000") == pytest.approx(21)
