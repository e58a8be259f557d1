"""PNG files with at most 256 colours: a third of what a browser's screenshot needs."""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Sequence

from playwright.sync_api import Page

GAP = 12  # pixels between two pictures

# Draws the pictures onto one canvas; its palette has the most frequent colours, and then
# those that differ most from them.
_PACK = """
async ([pictures, isBeside, gap]) => {
  const images = await Promise.all(pictures.map(async (one) => {
    const image = new Image();
    image.src = `data:image/png;base64,${one}`;
    await image.decode();
    return image;
  }));
  const [widths, heights] = [images.map((one) => one.width), images.map((one) => one.height)];
  const sum = (all) => all.reduce((a, b) => a + b, 0) + gap * (all.length - 1);
  const canvas = document.createElement("canvas");
  canvas.width = isBeside ? sum(widths) : Math.max(...widths);
  canvas.height = isBeside ? Math.max(...heights) : sum(heights);
  const context = canvas.getContext("2d");
  context.fillStyle = "#8a939e";
  context.fillRect(0, 0, canvas.width, canvas.height);
  let at = 0;
  for (const image of images) {
    context.drawImage(image, isBeside ? at : 0, isBeside ? 0 : at);
    at += gap + (isBeside ? image.width : image.height);
  }
  const data = context.getImageData(0, 0, canvas.width, canvas.height).data;
  const counts = new Map();
  const keys = new Uint32Array(data.length / 4);
  for (let i = 0; i < keys.length; i++) {
    const key = (data[4 * i] << 16) | (data[4 * i + 1] << 8) | data[4 * i + 2];
    keys[i] = key;
    counts.set(key, (counts.get(key) ?? 0) + 1);
  }
  const parts = (key) => [key >> 16, (key >> 8) & 255, key & 255];
  const left = [...counts].sort((a, b) => b[1] - a[1]);
  const colours = left.splice(0, 160).map(([key]) => parts(key));
  const far = ([x, y, z], [r, g, b]) => (x - r) ** 2 + (y - g) ** 2 + (z - b) ** 2;
  const rare = left.map(([key, count]) => ({ colour: parts(key), count, away: Infinity }));
  for (const one of rare) {
    for (const colour of colours) one.away = Math.min(one.away, far(colour, one.colour));
  }
  while (colours.length < 256 && rare.length) {
    const value = (one) => one.away * Math.sqrt(one.count);
    const best = rare.reduce((a, b) => (value(b) > value(a) ? b : a));
    rare.splice(rare.indexOf(best), 1);
    colours.push(best.colour);
    for (const one of rare) one.away = Math.min(one.away, far(best.colour, one.colour));
  }
  const nearest = (key) => {
    const colour = parts(key);
    let [best, least] = [0, Infinity];
    colours.forEach((other, index) => {
      const distance = far(other, colour);
      if (distance < least) [best, least] = [index, distance];
    });
    return best;
  };
  const places = new Map([...counts.keys()].map((key) => [key, nearest(key)]));
  let text = "";
  for (const key of keys) text += String.fromCharCode(places.get(key));
  return [canvas.width, canvas.height, colours.flat(), btoa(text)];
}
"""


def packed(page: Page, pictures: Sequence[bytes], *, is_beside: bool = False) -> bytes:
    """One PNG of these, beside or above each other; `page` is any page, which does the work."""
    texts = [base64.b64encode(one).decode() for one in pictures]
    width, height, palette, indices = page.evaluate(_PACK, [texts, is_beside, GAP])
    pixels = base64.b64decode(indices)
    rows = b"".join(b"\0" + pixels[y * width : (y + 1) * width] for y in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    return b"".join(
        [
            b"\x89PNG\r\n\x1a\n",
            _chunk(b"IHDR", header),
            _chunk(b"PLTE", bytes(palette)),
            _chunk(b"IDAT", zlib.compress(rows, 9)),
            _chunk(b"IEND", b""),
        ]
    )


def _chunk(kind: bytes, content: bytes) -> bytes:
    checksum = struct.pack(">I", zlib.crc32(kind + content))
    return struct.pack(">I", len(content)) + kind + content + checksum
