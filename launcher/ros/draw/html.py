"""A drawing as one HTML file that works offline, with pan and zoom."""

from __future__ import annotations

import html

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
  html, body {{ margin: 0; height: 100%; overflow: hidden; font: 13px sans-serif; }}
  body {{ display: flex; flex-direction: column; background: #fff; }}
  #view {{ flex: 1; min-height: 0; cursor: grab; touch-action: none; }}
  #view.held {{ cursor: grabbing; }}
  #view svg {{ width: 100%; height: 100%; display: block; }}
  #bar {{ padding: 6px 10px; border-bottom: 1px solid #cbd5e0; color: #4a5568; }}
  .dim {{ opacity: 0.15; }}
  /* light and dark change places, and the colours stay: what is red has to be red */
  @media (prefers-color-scheme: dark) {{
    html {{ background: #fff; filter: invert(0.9) hue-rotate(180deg); }}
  }}
</style>
</head>
<body>
<div id="bar">{title} &middot; {caption} &middot; drag to move, wheel to zoom,
double click to fit, click a node or topic for its neighbours</div>
<div id="view">
{svg}
</div>
<script>
"use strict";
const view = document.getElementById("view");
const svg = view.querySelector("svg");
svg.removeAttribute("width");
svg.removeAttribute("height");
const whole = svg.getAttribute("viewBox").split(/[ ,]+/).map(Number);
let box = whole.slice();
let held = null;

function show() {{ svg.setAttribute("viewBox", box.join(" ")); }}

function scale() {{
  return Math.max(box[2] / view.clientWidth, box[3] / view.clientHeight);
}}

view.addEventListener("wheel", (event) => {{
  event.preventDefault();
  const factor = Math.min(8, Math.max(0.125, Math.exp(event.deltaY * 0.0015)));
  const place = view.getBoundingClientRect();
  const unit = scale();  // the drawing is in the middle, whatever the shape of the window
  const x = box[0] + box[2] / 2 + (event.clientX - place.left - place.width / 2) * unit;
  const y = box[1] + box[3] / 2 + (event.clientY - place.top - place.height / 2) * unit;
  box = [x + (box[0] - x) * factor, y + (box[1] - y) * factor, box[2] * factor, box[3] * factor];
  show();
}}, {{ passive: false }});

view.addEventListener("pointerdown", (event) => {{
  held = {{ x: event.clientX, y: event.clientY, box: box.slice() }};
  view.classList.add("held");
}});

window.addEventListener("pointermove", (event) => {{
  if (held === null) {{ return; }}
  const unit = scale();
  box[0] = held.box[0] - (event.clientX - held.x) * unit;
  box[1] = held.box[1] - (event.clientY - held.y) * unit;
  show();
}});

window.addEventListener("pointerup", () => {{
  held = null;
  view.classList.remove("held");
}});

view.addEventListener("dblclick", () => {{ box = whole.slice(); show(); }});

function nameOf(group) {{ return group.querySelector("title").textContent; }}

view.addEventListener("click", (event) => {{
  const picked = event.target.closest("g.node");
  const parts = svg.querySelectorAll("g.node, g.edge");
  for (const part of parts) {{ part.classList.toggle("dim", picked !== null); }}
  if (picked === null) {{ return; }}
  const near = new Set([nameOf(picked)]);
  for (const edge of svg.querySelectorAll("g.edge")) {{
    const ends = nameOf(edge).split("->");
    if (ends.includes(nameOf(picked))) {{
      edge.classList.remove("dim");
      for (const end of ends) {{ near.add(end); }}
    }}
  }}
  for (const node of svg.querySelectorAll("g.node")) {{
    if (near.has(nameOf(node))) {{ node.classList.remove("dim"); }}
  }}
}});
</script>
</body>
</html>
"""


def to_html(svg: str, *, title: str, caption: str) -> str:
    """The page; `svg` is a drawing of Graphviz."""
    drawing = svg[svg.index("<svg") :]  # without the XML head and the doctype
    return _PAGE.format(svg=drawing, title=html.escape(title), caption=html.escape(caption))
