// Lines with SGR colour escapes as pieces of text with classes; other controls become visible.

export const SGR = /\x1b\[([0-9;:]*)m/g;
export const OTHER_ESCAPES = /\x1b\[[0-9;:?]*[@-ln-~]|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)/g;
const CONTROLS = /[\x00-\x08\x0a-\x1f\x7f]/g;

// NUL becomes the picture of NUL, and so on.
const picture = (char) =>
  String.fromCharCode(char === "\x7f" ? 0x2421 : 0x2400 + char.charCodeAt(0));

const visible = (text) => text.replace(CONTROLS, picture);

// The text without colours, for searches and files.
export function plain(text) {
  if (!text.includes("\x1b")) return text;
  const found = text.replace(SGR, "");
  return found.includes("\x1b") ? found.replace(OTHER_ESCAPES, "") : found;
}

// Apply the numbers of one escape to a style {colour, isBold, isDim, isItalic, isUnderlined}.
function change(style, words) {
  const numbers = words.split(/[;:]/).map(Number);
  for (let i = 0; i < numbers.length; i++) {
    const number = numbers[i];
    if (number === 0) style = {};
    else if (number === 1) style = { ...style, isBold: true };
    else if (number === 2) style = { ...style, isDim: true };
    else if (number === 3) style = { ...style, isItalic: true };
    else if (number === 4) style = { ...style, isUnderlined: true };
    else if (number === 22) style = { ...style, isBold: false, isDim: false };
    else if (number === 23) style = { ...style, isItalic: false };
    else if (number === 24) style = { ...style, isUnderlined: false };
    else if (number >= 30 && number <= 37) style = { ...style, colour: number - 30 };
    else if (number >= 90 && number <= 97) style = { ...style, colour: number - 90 };
    else if (number === 39) style = { ...style, colour: undefined };
    else if (number === 38 || number === 48) {
      if (number === 38) style = { ...style, colour: nearest(numbers.slice(i + 1)) };
      i += numbers[i + 1] === 5 ? 2 : 4;
    }
  }
  return style;
}

// The nearest of the eight colours for `5;N` (of 256) or `2;R;G;B`: the page has its own shades.
function nearest(numbers) {
  if (numbers[0] === 5 && numbers[1] < 16) return numbers[1] % 8;
  let [red, green, blue] = numbers.slice(1);
  if (numbers[0] === 5) {
    if (numbers[1] >= 232) return undefined;
    const cube = numbers[1] - 16;
    [red, green, blue] = [Math.floor(cube / 36), Math.floor(cube / 6) % 6, cube % 6];
  }
  const half = Math.max(red, green, blue, 1) / 2;
  const index = (red > half) + 2 * (green > half) + 4 * (blue > half);
  return index === 7 ? undefined : index;
}

function classes(style) {
  const found = [];
  if (style.colour !== undefined) found.push(`sgr-${style.colour}`);
  if (style.isBold) found.push("sgr-bold");
  if (style.isDim) found.push("sgr-dim");
  if (style.isItalic) found.push("sgr-italic");
  if (style.isUnderlined) found.push("sgr-underlined");
  return found.join(" ");
}

// Pieces [class, text]; class is empty for plain text.
export function pieces(text, withColours = true) {
  if (!text.includes("\x1b")) return [["", visible(text)]];
  if (!withColours) return [["", visible(plain(text))]];
  const found = [];
  const clean = text.replace(OTHER_ESCAPES, "");
  let style = {};
  let end = 0;
  for (const match of clean.matchAll(SGR)) {
    if (match.index > end) found.push([classes(style), visible(clean.slice(end, match.index))]);
    style = change(style, match[1]);
    end = match.index + match[0].length;
  }
  if (end < clean.length) found.push([classes(style), visible(clean.slice(end))]);
  return found;
}
