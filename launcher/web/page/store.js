// What is known of the run: messages of the server (launcher/web) become reactive state.

import { reactive, ref, shallowReactive, shallowRef } from "vue";
import { LogBuffer } from "page/log_buffer.js";

const KEEP_SAMPLES = 120; // two minutes, as the server; so many are drawn
const KEEP_EVENTS = 4000; // as the server
const KEEP_MESSAGES = 200;
const KEEP_POINTS = 20_000; // of one plot, as the server

// link: connecting, open, lost, ended or frozen; `text` says more. `silent_s`: since the launcher
// has sent something to the server.
export const link = reactive({ state: "connecting", text: "", since: 0, silent_s: 0 });
export const hello = shallowRef(null);
export const processes = shallowRef([]); // rows of `ps`
export const wall = ref(0); // the server's time at the last message of the processes
export const history = shallowReactive(new Map()); // name -> {cpu, memory, lines}: arrays
export const runEvents = shallowRef([]);
export const log = new LogBuffer();
export const graph = shallowRef(null);
export const traffic = shallowRef({}); // topic -> rate_hz, bytes_per_s, age_s, count, state
export const messages = shallowReactive(new Map()); // topic -> last messages, newest last
export const plots = shallowReactive(new Map()); // "topic\nfield" -> [[wall, value]]
export const plan = shallowRef(null);
export const expectations = shallowRef([]);
export const faults = shallowRef(null); // name -> fault; null: the run is not watched
export const notices = shallowRef([]); // texts that the server has for the reader

// What panels share: chosen processes, and the moment (wall time) that was clicked.
export const chosen = reactive({ processes: new Set(), moment: null });

function keepHistory(message) {
  const known = new Set(message.processes.map((row) => row.name));
  for (const row of message.processes) {
    const before = history.get(row.name);
    const line = (key, value) => [...(before?.[key] ?? []), value].slice(-KEEP_SAMPLES);
    history.set(row.name, {
      cpu: line("cpu", row.cpu_percent),
      memory: line("memory", row.uss_bytes),
      lines: line("lines", row.lines_per_s),
    });
  }
  for (const name of history.keys()) if (!known.has(name)) history.delete(name);
}

const handlers = {
  hello(message) {
    const isSame =
      hello.value?.server === message.server && hello.value?.run.id === message.run.id;
    if (!isSame) {
      log.clear();
      history.clear();
      messages.clear();
      plots.clear();
      graph.value = null;
      expectations.value = [];
      faults.value = null;
    }
    hello.value = message;
  },
  history(message) {
    for (const [name, lines] of Object.entries(message.processes)) {
      history.set(name, lines);
    }
  },
  processes(message) {
    if (message.wall !== wall.value) keepHistory(message);
    wall.value = message.wall;
    processes.value = message.processes;
  },
  run_events(message) {
    const before = message.reset ? [] : runEvents.value;
    runEvents.value = [...before, ...message.items].slice(-KEEP_EVENTS);
  },
  lines(message) {
    log.add(message.first, message.lines);
  },
  slow(message) {
    notices.value = [...notices.value, message.text].slice(-20);
  },
  probe({ available, reason }) {
    if (hello.value) hello.value = { ...hello.value, graph: { available, reason } };
    if (!available) traffic.value = {};
  },
  graph(message) {
    graph.value = message;
  },
  topics(message) {
    traffic.value = message.topics;
  },
  message(message) {
    const before = messages.get(message.topic) ?? [];
    messages.set(message.topic, [...before, message].slice(-KEEP_MESSAGES));
  },
  points(message) {
    const key = `${message.topic}\n${message.field}`;
    const before = message.reset ? [] : (plots.get(key) ?? []);
    plots.set(key, [...before, ...message.points].slice(-KEEP_POINTS));
  },
  plan(message) {
    plan.value = message;
  },
  expectations(message) {
    expectations.value = message.items;
  },
  faults({ items, gone, reset }) {
    const all = new Map(reset ? [] : faults.value);
    for (const one of items) all.set(one.fault, one);
    for (const name of gone) all.delete(name);
    faults.value = all;
  },
  alive(message) {
    link.silent_s = message.silent_s;
  },
  ended(message) {
    link.state = "ended";
    link.text = message.text;
    link.since = message.wall;
  },
};

export function apply(message) {
  handlers[message.event]?.(message);
}
