// Entries of the event log as sentences, with a shape for the timeline.

import { duration } from "page/format.js";

const SIGNALS = {
  1: "SIGHUP", 2: "SIGINT", 3: "SIGQUIT", 4: "SIGILL", 5: "SIGTRAP", 6: "SIGABRT", 7: "SIGBUS",
  8: "SIGFPE", 9: "SIGKILL", 10: "SIGUSR1", 11: "SIGSEGV", 12: "SIGUSR2", 13: "SIGPIPE",
  14: "SIGALRM", 15: "SIGTERM", 18: "SIGCONT", 19: "SIGSTOP", 20: "SIGTSTP",
};

export const signalName = (number) => SIGNALS[number] ?? `signal ${number}`;

function exitText(code) {
  return code < 0 ? `ended by ${signalName(-code)}` : `exited with code ${code}`;
}

const list = (names) => (names?.length ? names.join(", ") : "none");

const WHY = {
  ready: "what it waited for is ready",
  timeout: "it has waited long enough",
  requested: "it was requested",
  fail: "what it waited for has not come: it is not started",
  "stop-run": "what it waited for has not come: the run ends",
};

// Kind of event -> {shape, tone, text(entry)}; `text` follows the name of the process.
const KINDS = {
  started: {
    shape: "start",
    tone: "good",
    text: (e) => `started, pid ${e.pid}${e.restarts ? `, restart ${e.restarts}` : ""}`,
  },
  ended: {
    shape: (e) => (e.returncode !== 0 && !e.asked ? "crash" : "end"),
    tone: (e) => (e.returncode !== 0 && !e.asked ? "bad" : "muted"),
    text: (e) => {
      const next = e.restart_in_s === null || e.restart_in_s === undefined
        ? "" : `; restart in ${duration(e.restart_in_s)}`;
      return `${exitText(e.returncode)}${e.asked ? ", requested" : ""}${next}`;
    },
  },
  signal: { shape: "signal", tone: "warn", text: (e) => `got ${signalName(e.signal)}` },
  asked: {
    shape: "asked",
    tone: "accent",
    text: (e) => `a user asked: ${e.verb}${e.signal ? ` with ${e.signal}` : ""}`,
  },
  ready: { shape: "ready", tone: "good", text: (e) => `ready after ${duration(e.ready_s)}` },
  waiting: {
    shape: "waiting",
    tone: "muted",
    text: (e) => `waits for ${list(e.after)}, at most ${duration(e.timeout_s)}`,
  },
  released: {
    shape: "ready",
    tone: (e) => (["fail", "stop-run"].includes(e.why) ? "bad" : "muted"),
    text: (e) => `has waited ${duration(e.waited_s)}: ${WHY[e.why] ?? e.why}`,
  },
  "not started": { shape: "crash", tone: "bad", text: (e) => `could not be started: ${e.reason}` },
  withdrawn: { shape: "end", tone: "muted", text: () => "its start was cancelled" },
  stuck: {
    shape: "alarm",
    tone: "bad",
    text: (e) => `does not end, not even by SIGKILL${e.sleeps ? ` (${e.sleeps})` : ""}`,
  },
  "not responding": {
    shape: "alarm",
    tone: "bad",
    text: (e) => `does not respond for ${duration(e.silent_s)}`,
  },
  responds: {
    shape: "ready",
    tone: "good",
    text: (e) => `responds again after ${duration(e.after_s)}`,
  },
  "over budget": {
    shape: "alarm",
    tone: "warn",
    text: (e) => `uses more than its budget: ${e.action}`,
  },
  "member ended": {
    shape: (e) => (e.returncode ? "crash" : "end"),
    tone: (e) => (e.returncode ? "bad" : "muted"),
    text: (e) => `${e.member} in it ${exitText(e.returncode)}`,
  },
  adopted: { shape: "start", tone: "good", text: (e) => `was running already, pid ${e.pid}` },
  "files changed": {
    shape: "change",
    tone: "accent",
    text: (e) => `files changed: ${list(e.files)}; restarts: ${list(e.restarts)}`,
  },
  reloaded: {
    shape: "change",
    tone: "accent",
    text: (e) => {
      const changes = ["new", "gone", "changed"].filter((key) => e[key]?.length);
      return `launch file reloaded${changes.map((key) => `; ${key}: ${list(e[key])}`).join("")}`;
    },
  },
  snapshot: { shape: "snapshot", tone: "accent", text: (e) => `snapshot ${e.path} (${e.reason})` },
  stopping: { shape: "stop", tone: "warn", text: (e) => `the run stops: ${e.reason}` },
  finished: {
    shape: "stop",
    tone: (e) => (e.exit_code ? "bad" : "muted"),
    text: (e) => `the run has ended with exit code ${e.exit_code}`,
  },
  link: {
    shape: "change",
    tone: (e) => (e.state === "ready" ? "good" : "warn"),
    text: (e) => `host ${e.host}: ${e.state}${e.reason ? ` (${e.reason})` : ""}`,
  },
  expectation: {
    shape: (e) => (e.state === "failed" ? "unmet" : "expected"),
    tone: (e) => (e.state === "failed" ? "bad" : "good"),
    text: (e) => `expectation ${e.state}: ${e.title}${e.detail ? ` (${e.detail})` : ""}`,
  },
  "launch file": { shape: "file", tone: "accent", text: (e) => e.text },
};

const PLAIN = new Set(["wall_s", "monotonic_s", "event", "process", "host"]);

function otherText(entry) {
  const facts = Object.entries(entry)
    .filter(([key]) => !PLAIN.has(key))
    .map(([key, value]) => `${key}=${typeof value === "object" ? JSON.stringify(value) : value}`);
  return `${entry.event} ${facts.join(" ")}`.trim();
}

// {key, wall, kind, process, shape, tone, text} of an entry.
export function described(entry, key) {
  const kind = Object.hasOwn(KINDS, entry.event) ? KINDS[entry.event] : undefined;
  const of = (value) => (typeof value === "function" ? value(entry) : value);
  return {
    key,
    wall: entry.wall_s,
    kind: entry.event,
    process: entry.process ?? null,
    shape: of(kind?.shape ?? "other"),
    tone: of(kind?.tone ?? "muted"),
    text: kind ? kind.text(entry) : otherText(entry),
    entry,
  };
}

// Each kind has a shape of its own, not only a colour; about 10 wide, drawn from its middle. They
// are not moved by `transform`: thousands of these make browsers slow.
const SHAPES = {
  start: "m-3,-5 l8,5 l-8,5 z",
  end: "m-4,-4 h8 v8 h-8 z",
  crash:
    "m-5.5,-3 l2.5,-2.5 l3,3 l3,-3 l2.5,2.5 l-3,3 l3,3 l-2.5,2.5 l-3,-3 l-3,3 l-2.5,-2.5 l3,-3 z",
  signal: "m0,-5.5 l5,5.5 l-5,5.5 l-5,-5.5 z",
  asked: "m-4.5,0 a4.5,4.5 0 1,0 9,0 a4.5,4.5 0 1,0 -9,0 z",
  ready: "m-5,0 l3.5,3.5 l6.5,-7 l-1.2,-1.5 l-5.3,5.8 l-2.1,-2.2 z",
  waiting: "m-4,-5 h8 l-8,10 h8 z",
  alarm: "m0,-5.5 l5.5,10 h-11 z",
  change: "m-5,-1.5 h3.5 v-3.5 h3 v3.5 h3.5 v3 h-3.5 v3.5 h-3 v-3.5 h-3.5 z",
  snapshot: "m-5,-3 h3 l1,-2 h2 l1,2 h3 v7 h-10 z",
  stop: "m-1.5,-7 h3 v14 h-3 z",
  expected:
    "m0,-6 l1.8,4.1 h4.2 l-3.4,2.7 l1.3,4.2 l-3.9,-2.5 l-3.9,2.5 l1.3,-4.2 l-3.4,-2.7 h4.2 z",
  unmet: "m-5,-5 h10 v10 h-10 z m2,2 v6 h6 v-6 z",
  file: "m-4,-5 h6 l2,2 v8 h-8 z",
  other: "m-3,0 a3,3 0 1,0 6,0 a3,3 0 1,0 -6,0 z",
};

// The path of a shape around a point.
export const shapeAt = (shape, x = 0, y = 0) => `M${x.toFixed(1)} ${y}${SHAPES[shape]}`;
