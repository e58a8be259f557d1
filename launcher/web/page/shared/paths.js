// Paths into messages such as `pose.x` and `ranges[3]`: the grammar of launcher/web/numbers.py.

// What a string of JSON holds, if that is an object or an array; else undefined.
export function opened(value) {
  if (typeof value !== "string" || !/^\s*[[{]/.test(value)) return undefined;
  try {
    const found = JSON.parse(value);
    return found !== null && typeof found === "object" ? found : undefined;
  } catch {
    return undefined;
  }
}

// The path of a member: `key` is a name, or the index in an array. Null if it cannot be written.
export function childPath(path, key) {
  if (path === null) return null;
  if (typeof key === "number") return path === "" ? null : `${path}[${key}]`;
  if (key === "" || /[.[\]]/.test(key)) return null;
  return path === "" ? key : `${path}.${key}`;
}

// Whether a plot can show it. Numbers that JSON does not have (NaN) are sent as text.
export const isNumeric = (value) =>
  typeof value === "number" ||
  typeof value === "boolean" ||
  (typeof value === "string" && /^\s*-?(\d+(\.\d+)?([eE][+-]?\d+)?|nan|inf)\s*$/.test(value));

// YAML of plain data, good enough to be read by a YAML parser: strings are quoted as in JSON.
export function toYaml(value, indent = "") {
  if (Array.isArray(value)) {
    if (!value.length) return "[]";
    if (value.every((one) => one === null || typeof one !== "object")) {
      return `[${value.map((one) => scalar(one)).join(", ")}]`;
    }
    return value.map((one) => `\n${indent}- ${toYaml(one, `${indent}  `).trimStart()}`).join("");
  }
  if (value !== null && typeof value === "object") {
    const keys = Object.keys(value);
    if (!keys.length) return "{}";
    return keys
      .map((key) => `\n${indent}${member(key)}: ${toYaml(value[key], `${indent}  `)}`)
      .join("");
  }
  return scalar(value);
}

const member = (key) => (/^[A-Za-z_][\w]*$/.test(key) ? key : JSON.stringify(key));

function scalar(value) {
  if (typeof value !== "string") return JSON.stringify(value);
  const isPlain =
    /^[A-Za-z_/][\w/ -]*\w$/.test(value) && !/^(true|false|null|yes|no|on|off)$/i.test(value);
  return isPlain ? value : JSON.stringify(value);
}
