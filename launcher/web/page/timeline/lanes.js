// The event log as lanes: the lives of each process as bars, and marks for what happened.

import { described } from "page/timeline/marks.js";

export const RUN_LANE = "the run";
export const EXPECTED_LANE = "expectations";

// What the launch file did besides processes, from the plan; its times count from the start.
function planEvents(plan, started) {
  if (!plan) return [];
  const at = (one, text) => ({ event: "launch file", wall_s: started + (one.time ?? 0), text });
  const isDone = (one) => (one.phase ?? "run") === "run" || one.phase === "shutdown";
  const words = {
    logs: (one) => `launch file says: ${one.message}`,
    shutdowns: (one) => `launch file shuts down: ${one.reason}`,
    lifecycle: (one) => `lifecycle: ${one.node} ${one.transition}`,
    loads: (one) => `component ${one.plugin} into ${one.container}`,
  };
  return Object.entries(words).flatMap(([key, text]) =>
    (plan[key] ?? []).filter(isDone).map((one) => at(one, text(one))),
  );
}

function expectationEvents(expectations) {
  return expectations
    .filter((one) => one.wall !== null && one.wall !== undefined && one.state !== "open")
    .map((one) => ({
      event: "expectation",
      wall_s: one.wall,
      state: one.state,
      text: `expectation ${one.state}: ${one.title}${one.detail ? ` (${one.detail})` : ""}`,
    }));
}

// All events in order of their time, described; `key` counts them.
export function allEvents(runEvents, plan, expectations, started) {
  const entries = [
    ...runEvents.filter((entry) => entry.event !== "resources"),
    ...planEvents(plan, started),
    ...expectationEvents(expectations),
  ];
  entries.sort((a, b) => a.wall_s - b.wall_s);
  return entries.map(described);
}

// The state that begins with an event; null: none does.
function stateAfter({ kind, entry }) {
  if (kind === "started" || kind === "adopted") return "running";
  if (kind === "waiting") return "waiting";
  if (kind === "not started") return "failed";
  if (kind === "withdrawn") return "stopped";
  if (kind === "asked" && entry.verb === "pause") return "paused";
  if (kind === "asked" && entry.verb === "resume") return "running";
  if (kind !== "ended") return null;
  if (entry.restart_in_s !== null && entry.restart_in_s !== undefined) return "backoff";
  return entry.asked || entry.returncode === 0 ? "stopped" : "failed";
}

function addBar(lane, event) {
  const state = stateAfter(event);
  if (!state) return;
  const last = lane.bars[lane.bars.length - 1];
  if (event.kind === "asked" && last?.state === state) return;
  if (last) last.to = event.wall;
  else if (event.kind === "ended") {
    // Its start is older than what is known of the events.
    lane.bars.push({ state: "running", from: null, to: event.wall });
  }
  lane.bars.push({ state, from: event.wall, to: null, pid: event.entry.pid });
}

// Lanes {name, bars: [{state, from, to}], marks: [event]}; `to` is null for what lasts, `from` for
// what began before the events that are known.
export function lanesOf(events, processes, wall) {
  const lanes = new Map();
  const lane = (name) => {
    if (!lanes.has(name)) lanes.set(name, { name, bars: [], marks: [], isProcess: false });
    return lanes.get(name);
  };
  lane(RUN_LANE);
  if (events.some((event) => event.kind === "expectation")) lane(EXPECTED_LANE);
  for (const row of processes) lane(row.name).isProcess = true;
  for (const event of events) {
    const name = event.kind === "expectation" ? EXPECTED_LANE : (event.process ?? RUN_LANE);
    const found = lane(name);
    found.marks.push(event);
    if (event.process !== null) {
      found.isProcess = true;
      addBar(found, event);
    }
  }
  for (const row of processes) {
    const found = lane(row.name);
    if (!found.bars.length && row.uptime_s !== null && row.uptime_s !== undefined) {
      found.bars.push({ state: "running", from: wall - row.uptime_s, to: null, pid: row.pid });
    }
  }
  return [...lanes.values()];
}

const STEPS = [
  0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600,
  900, 1800, 3600, 7200, 21600, 43200, 86400, 172800, 604800,
];

// Times of the axis, at least `apart` points from each other: {step, times}.
export function ticks(from, to, width, apart = 96) {
  const least = ((to - from) / Math.max(1, width)) * apart;
  const step = STEPS.find((one) => one >= least) ?? STEPS[STEPS.length - 1];
  const offset = step >= 60 ? new Date(from * 1000).getTimezoneOffset() * 60 : 0;
  const times = [];
  for (let time = Math.ceil((from - offset) / step) * step + offset; time <= to; time += step) {
    times.push(time);
  }
  return { step, times };
}

// At most one mark of a shape and tone per `apart` points: what lies on each other is not drawn.
export function thinned(marks, x, apart = 3) {
  const seen = new Set();
  return marks.filter((mark) => {
    const key = `${mark.shape} ${mark.tone} ${Math.round(x(mark.wall) / apart)}`;
    if (seen.has(key)) return false;
    seen.add(key);
    return true;
  });
}

// The same for bars {bar, left, width}: those that are wide, and of narrow ones one of each state per
// `apart` points. A process that restarts all day has thousands, which take seconds to draw.
export function thinnedBars(bars, apart = 3) {
  const seen = new Set();
  return bars.filter(({ bar, left, width }) => {
    if (width >= apart) return true;
    const key = `${bar.state} ${Math.round(left / apart)}`;
    if (seen.has(key)) return false;
    seen.add(key);
    return true;
  });
}
