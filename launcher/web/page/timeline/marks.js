// Shapes and tones of the entries of the event log; their texts come with them.

const isFailure = (e) => e.returncode !== 0 && !e.asked;
const byFailure = (e) => (isFailure(e) ? "bad" : "muted");

// Event -> [shape, tone], which may depend on the entry.
const MARKS = {
  started: ["start", "good"],
  adopted: ["start", "good"],
  ended: [(e) => (isFailure(e) ? "crash" : "end"), byFailure],
  "member ended": [(e) => (isFailure(e) ? "crash" : "end"), byFailure],
  "not started": ["crash", "bad"],
  withdrawn: ["end", "muted"],
  signal: ["signal", "warn"],
  asked: ["asked", "accent"],
  waiting: ["waiting", "muted"],
  released: ["ready", (e) => (["fail", "stop-run"].includes(e.why) ? "bad" : "muted")],
  ready: ["ready", "good"],
  responds: ["ready", "good"],
  "not responding": ["alarm", "bad"],
  fault: ["fault", "bad"],
  "fault healed": ["healed", "good"],
  "fault action": ["asked", (e) => (e.ok ? "accent" : "warn")],
  stuck: ["alarm", "bad"],
  "over budget": ["alarm", "warn"],
  "files changed": ["change", "accent"],
  reloaded: ["change", "accent"],
  link: ["change", (e) => (e.state === "ready" ? "good" : "warn")],
  injection: ["alarm", "accent"],
  "injection ended": ["ready", "muted"],
  snapshot: ["snapshot", "accent"],
  stopping: ["stop", "warn"],
  finished: ["stop", (e) => (e.exit_code ? "bad" : "muted")],
  expectation: [
    (e) => (e.state === "failed" ? "unmet" : "expected"),
    (e) => (e.state === "failed" ? "bad" : "good"),
  ],
  "launch file": ["file", "accent"],
};

// {key, wall, kind, process, shape, tone, text} of an entry; `text` follows the name of the process.
export function described(entry, key) {
  const mark = Object.hasOwn(MARKS, entry.event) ? MARKS[entry.event] : ["other", "muted"];
  const [shape, tone] = mark.map((one) => (typeof one === "function" ? one(entry) : one));
  const text = String(entry.text ?? entry.event);
  const process = entry.process ?? null;
  return { key, wall: entry.wall_s, kind: entry.event, process, shape, tone, text, entry };
}

// Each kind has a different shape, not only a colour; about 10 wide, drawn from its middle. They
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
  fault:
    "m-2.3,-5.5 h4.6 l3.2,3.2 v4.6 l-3.2,3.2 h-4.6 l-3.2,-3.2 v-4.6 z " +
    "m1.4,2 v4 h1.8 v-4 z m0,5.2 v1.8 h1.8 v-1.8 z",
  healed:
    "m-5,0 a5,5 0 1,0 10,0 a5,5 0 1,0 -10,0 z m2.4,0 a2.6,2.6 0 1,1 5.2,0 a2.6,2.6 0 1,1 -5.2,0 z",
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
