// Numbers and times for people.

const UNITS = ["B", "kB", "MB", "GB", "TB"];

// 12:03:04, or with milliseconds, of seconds since 1970, in local time.
export function clock(wall, withMs = false) {
  const date = new Date(wall * 1000);
  const text = date.toTimeString().slice(0, 8);
  return withMs ? `${text}.${String(date.getMilliseconds()).padStart(3, "0")}` : text;
}

// 2026-11-27, in local time.
export function day(wall) {
  const date = new Date(wall * 1000);
  const two = (value) => String(value).padStart(2, "0");
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())}`;
}

export function bytes(value) {
  if (value === null || value === undefined) return "";
  let unit = 0;
  while (value >= 1000 && unit < UNITS.length - 1) {
    value /= 1000;
    unit++;
  }
  return `${value >= 100 || unit === 0 ? value.toFixed(0) : value.toFixed(1)} ${UNITS[unit]}`;
}

export function duration(seconds) {
  if (seconds === null || seconds === undefined) return "";
  if (seconds < 60) return `${seconds < 10 ? seconds.toFixed(1) : seconds.toFixed(0)} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ${Math.floor(seconds % 60)} s`;
  if (seconds < 86400) {
    return `${Math.floor(seconds / 3600)} h ${Math.floor((seconds % 3600) / 60)} min`;
  }
  return `${Math.floor(seconds / 86400)} d ${Math.floor((seconds % 86400) / 3600)} h`;
}

// 1 process, 2 processes.
export const processCount = (count) => `${count} ${count === 1 ? "process" : "processes"}`;

export function rate(value) {
  if (value === null || value === undefined) return "";
  return value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2);
}
