// Values for a type: what a new one is, what a typed text means, and what is wrong with it.

const BITS = {
  byte: 8,
  char: 8,
  uint8: 8,
  uint16: 16,
  uint32: 32,
  uint64: 64,
  int8: 8,
  int16: 16,
  int32: 32,
  int64: 64,
};
const FLOATS = new Set(["float32", "float64", "float", "double"]);

export const isInteger = (type) => type in BITS;
export const isFloat = (type) => FLOATS.has(type);

// [smallest, largest] as BigInt.
export function range(type) {
  const bits = BigInt(BITS[type]);
  if (!type.startsWith("int")) return [0n, 2n ** bits - 1n];
  return [-(2n ** (bits - 1n)), 2n ** (bits - 1n) - 1n];
}

export function newItem(field) {
  if (field.fields) return newValue(field.fields);
  if (field.type === "bool") return false;
  return isInteger(field.type) || isFloat(field.type) ? 0 : "";
}

const clone = (value) => JSON.parse(JSON.stringify(value));

export const newValue = (fields) =>
  Object.fromEntries(fields.map((field) => [field.name, clone(field.default ?? newItem(field))]));

// What a text means for a type; the text itself if it means nothing. Large integers are BigInt.
export function parsed(type, text) {
  const trimmed = String(text ?? "").trim();
  if (isInteger(type) && /^(-?\d+|0x[\da-fA-F]+)$/.test(trimmed)) {
    const number = BigInt(trimmed);
    return Number.isSafeInteger(Number(number)) ? Number(number) : number;
  }
  if (isFloat(type) && trimmed !== "" && Number.isFinite(Number(trimmed))) return Number(trimmed);
  return text ?? "";
}

// The sentence about a single value, or "".
export function problem(field, value) {
  if (isInteger(field.type)) {
    if (typeof value !== "bigint" && !Number.isInteger(value)) return "a whole number is needed";
    const [least, most] = range(field.type);
    if (BigInt(value) < least || BigInt(value) > most)
      return `${field.type}: from ${least} to ${most}`;
  } else if (isFloat(field.type)) {
    const isWord = typeof value === "string" && /^[+-]?\.?(nan|inf)$/i.test(value.trim());
    if (typeof value !== "number" && !isWord) return "a number is needed";
  } else if (field.string_most && String(value).length > field.string_most) {
    return `at most ${field.string_most} characters`;
  }
  return "";
}

// All that is wrong with a value: [{path, text}].
export function problems(fields, value, path = "") {
  return fields.flatMap((field) => {
    const here = path ? `${path}.${field.name}` : field.name;
    const held = value?.[field.name];
    if (!field.array) return single(field, held, here);
    if (!Array.isArray(held)) return [{ path: here, text: "a list is needed" }];
    return [
      ...countProblem(field, held, here),
      ...held.flatMap((one, index) => single(field, one, `${here}[${index}]`)),
    ];
  });
}

function single(field, value, path) {
  if (field.fields) return problems(field.fields, value, path);
  const text = problem(field, value);
  return text ? [{ path, text }] : [];
}

function countProblem({ array }, held, path) {
  if (array.size !== null && held.length !== array.size)
    return [{ path, text: `${array.size} items are needed` }];
  if (array.most !== null && held.length > array.most)
    return [{ path, text: `at most ${array.most} items` }];
  return [];
}

// Tokens of JSON: a string, or a number.
const TOKENS = /"(?:\\.|[^"\\])*"|-?\d[\d.eE+-]*/g;
const LARGE = "\0integer "; // JSON has no zero character in a string: nobody has typed this

// JSON.parse, but integers that are too large for a number of JavaScript become BigInt.
export function parsedJson(text) {
  const isLarge = (token) => /^-?[1-9]\d*$/.test(token) && !Number.isSafeInteger(Number(token));
  const marked = text.replace(TOKENS, (token) =>
    isLarge(token) ? JSON.stringify(LARGE + token) : token,
  );
  return JSON.parse(marked, (_, value) =>
    typeof value === "string" && value.startsWith(LARGE)
      ? BigInt(value.slice(LARGE.length))
      : value,
  );
}

// JSON, with integers that are too large for a number of JavaScript written out.
export function textOf(value, indent = "") {
  if (typeof value === "bigint") return String(value);
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  const inner = `${indent}  `;
  const isFlat =
    Array.isArray(value) && value.every((one) => one === null || typeof one !== "object");
  if (isFlat) return `[${value.map((one) => textOf(one)).join(", ")}]`;
  const parts = Array.isArray(value)
    ? value.map((one) => textOf(one, inner))
    : Object.entries(value).map(([key, one]) => `${JSON.stringify(key)}: ${textOf(one, inner)}`);
  const [open, close] = Array.isArray(value) ? "[]" : "{}";
  return parts.length
    ? `${open}\n${inner}${parts.join(`,\n${inner}`)}\n${indent}${close}`
    : open + close;
}
