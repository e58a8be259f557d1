// What a row of `ps` means for people: words, marks, order, and the verbs that make sense.

import { bytes, duration, rate } from "page/format.js";

// Shape and word of each state; `tone` is a class of page.css.
export const STATES = {
  RUNNING: { icon: "play_circle", word: "running", tone: "good" },
  STARTING: { icon: "hourglass_top", word: "starting", tone: "warn" },
  STOPPING: { icon: "hourglass_bottom", word: "stopping", tone: "warn" },
  BACKOFF: { icon: "replay", word: "waits to restart", tone: "warn" },
  STOPPED: { icon: "stop_circle", word: "stopped", tone: "muted" },
  EXITED: { icon: "check_circle", word: "exited", tone: "muted" },
  FATAL: { icon: "cancel", word: "failed", tone: "bad" },
};
const UNKNOWN = { icon: "help", word: "unknown", tone: "muted" };
const ALIVE = new Set(["RUNNING", "STARTING", "STOPPING"]);
const ENDED = new Set(["STOPPED", "EXITED", "FATAL"]);
const ORDER = ["FATAL", "BACKOFF", "EXITED", "STOPPED", "STOPPING", "STARTING", "RUNNING"];

export function stateOf(row) {
  const state = STATES[row.state] ?? { ...UNKNOWN, word: String(row.state).toLowerCase() };
  const end = row.last_exit;
  if (row.paused) return { icon: "pause_circle", word: "paused", tone: "warn" };
  if (!ENDED.has(row.state) || !end) return state;
  const isBad = !end.asked && end.returncode !== 0;
  return {
    icon: isBad ? "cancel" : state.icon,
    word: `${state.word}: ${end.text}`,
    tone: isBad ? "bad" : state.tone,
  };
}

// The last error line; what Python writes when it is interrupted is none.
export function errorOf(row) {
  return row.last_error?.text.trim() === "KeyboardInterrupt" ? null : row.last_error;
}

// What else is worth a mark: [icon, text].
export function marksOf(row) {
  const marks = [];
  if (row.muted_by_name) marks.push(["volume_off", "muted"]);
  if (row.hidden_by === "solo") marks.push(["visibility_off", "hidden by solo"]);
  if (row.level) marks.push(["filter_list", `${row.level} and above`]);
  if (row.grep) marks.push(["filter_list", `lines with ${row.grep}`]);
  if (row.not_responding_s) {
    marks.push(["warning", `does not respond for ${duration(row.not_responding_s)}`]);
  }
  if (row.waiting_for) marks.push(["hourglass_top", `waiting for ${row.waiting_for}`]);
  else if (row.lacks) marks.push(["hourglass_top", `not ready: ${row.lacks}`]);
  if (row.unreachable_s) {
    marks.push(["cloud_off", `unreachable for ${duration(row.unreachable_s)}`]);
  }
  if (row.faults?.length) {
    const more = row.faults.length > 1 ? ` +${row.faults.length - 1}` : "";
    marks.push(["report", `fault: ${row.faults[0]}${more}`]);
  }
  if (row.debugger) marks.push(["bug_report", `debugger at ${row.debugger}`]);
  return marks;
}

// The verbs of the page: name, icon, key, options, and whether one makes sense for a row.
export const ACTIONS = [
  { name: "start", icon: "play_arrow", key: "", fits: (row) => canStart(row) },
  { name: "stop", icon: "stop", key: "s", fits: (row) => canStop(row) },
  { name: "restart", icon: "replay", key: "r", fits: (row) => row.state !== "STOPPING" },
  { name: "kill", icon: "dangerous", key: "k", fits: (row) => row.pid !== null },
  { name: "mute", icon: "volume_off", key: "m", fits: (row) => !row.muted_by_name },
  { name: "unmute", icon: "volume_up", key: "m", fits: (row) => row.muted_by_name },
  { name: "pause", icon: "pause", key: "", fits: (row) => row.pid !== null && !row.paused },
  { name: "resume", icon: "play_circle_outline", key: "", fits: (row) => row.paused },
];

const canStart = (row) => ENDED.has(row.state) || row.state === "BACKOFF" || !!row.waiting_for;
const canStop = (row) =>
  (ALIVE.has(row.state) && row.state !== "STOPPING") || row.state === "BACKOFF";

// The names of the verbs that make sense for some of these rows, in one text.
export const fitsOf = (rows) =>
  ACTIONS.filter((one) => rows.some(one.fits)).map((one) => one.name).join(" ");

export const actionNamed = (name) => ACTIONS.find((one) => one.name === name);

// Columns: `of` is what is sorted, `text` what is shown.
export const COLUMNS = [
  { name: "state", label: "State", of: (row) => ORDER.indexOf(row.state) },
  { name: "name", label: "Name", of: (row) => row.name },
  { name: "host", label: "Host", of: (row) => row.host ?? "", text: (row) => row.host ?? "" },
  { name: "pid", label: "Pid", isNumber: true, of: (row) => row.pid, text: (row) => row.pid ?? "" },
  {
    name: "uptime",
    label: "Up",
    isNumber: true,
    of: (row) => row.uptime_s,
    text: (row) => uptimeText(row.uptime_s),
  },
  {
    name: "restarts",
    label: "Restarts",
    isNumber: true,
    of: (row) => row.restarts,
    text: (row) => row.restarts || "",
  },
  { name: "cpu", label: "CPU", isNumber: true, of: (row) => row.cpu_percent, text: cpuText },
  {
    name: "memory",
    label: "Memory",
    isNumber: true,
    of: (row) => row.uss_bytes,
    text: (row) => bytes(row.uss_bytes),
  },
  {
    name: "lines",
    label: "Lines/s",
    isNumber: true,
    of: (row) => row.lines_per_s,
    text: (row) => (row.lines_per_s ? rate(row.lines_per_s) : ""),
  },
  { name: "error", label: "Last error", of: (row) => errorOf(row)?.time ?? null },
];

// 4:05, 3:04:05 or 2 d 3:04:05.
function uptimeText(seconds) {
  if (seconds === null || seconds === undefined) return "";
  const two = (value) => String(Math.floor(value)).padStart(2, "0");
  const [days, hours] = [Math.floor(seconds / 86400), Math.floor((seconds % 86400) / 3600)];
  const rest = `${two((seconds % 3600) / 60)}:${two(seconds % 60)}`;
  if (!days && !hours) return rest.replace(/^0/, "");
  return `${days ? `${days} d ` : ""}${hours}:${rest}`;
}

function cpuText(row) {
  if (row.cpu_percent === null || row.cpu_percent === undefined) return "";
  return `${row.cpu_percent.toFixed(row.cpu_percent < 10 ? 1 : 0)} %`;
}

function compare(a, b) {
  if (typeof a === "string" && typeof b === "string") {
    return a.localeCompare(b, undefined, { numeric: true });
  }
  return a < b ? -1 : a > b ? 1 : 0;
}

// A sorted copy; what has no value comes last in both directions.
export function sorted(rows, by, isDescending) {
  const column = COLUMNS.find((one) => one.name === by);
  if (!column) return rows;
  const isMissing = (value) => value === null || value === undefined || value === "";
  return [...rows].sort((a, b) => {
    const [left, right] = [column.of(a), column.of(b)];
    if (isMissing(left) || isMissing(right)) return isMissing(left) - isMissing(right);
    return isDescending ? compare(right, left) : compare(left, right);
  });
}

// Rows in which every word of the text occurs: names, nodes, state, host, pid, last error.
export function matching(rows, text) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  if (!words.length) return rows;
  return rows.filter((row) => {
    const marks = marksOf(row).map((mark) => mark[1]);
    const facts = [row.name, ...(row.node_names ?? []), stateOf(row).word, row.host, row.pid];
    const all = [...facts, ...marks, errorOf(row)?.text].join("\n").toLowerCase();
    return words.every((word) => all.includes(word));
  });
}
