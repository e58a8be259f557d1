// The connection to the server, or the messages that are frozen into this file.

import { apply, hello, link, log } from "page/store.js";

const RETRY_MS = [250, 500, 1000, 2000, 5000];
const SILENT_MS = 8000; // the server sends something every 2 s
const LOST = "The connection was lost before the answer. It may still be carried out.";
const KEY = "launcher-key";

const subscriptions = new Map(); // text of one -> {word, fields, count}
const waiting = new Map(); // id -> resolve
let socket = null;
let nextId = 1;
let failures = 0;
let receivedAt = 0;
let hasBegun = () => {};

export class RequestError extends Error {
  constructor(error) {
    super(error.message);
    this.code = error.code;
    this.hint = error.hint;
  }
}

// The whole answer {ok, result, text}; RequestError if the server refuses.
export async function request(word, fields = {}) {
  if (!socket || socket.readyState !== WebSocket.OPEN) {
    throw new RequestError({ code: "closed", message: "There is no connection to the run." });
  }
  const id = nextId++;
  const answer = new Promise((resolve) => waiting.set(id, resolve));
  socket.send(JSON.stringify({ id, do: word, ...fields }));
  const found = await answer;
  if (!found.ok) throw new RequestError(found.error);
  return found;
}

// A request that can be ended before it is done: {answer, cancel}; `cancel` asks for that.
export function cancellable(word, fields = {}) {
  const id = nextId; // `request` takes it at once
  return { answer: request(word, fields), cancel: () => request("cancel", { of: id }) };
}

// Carry out a verb of the control socket, such as run("stop", ["robot_2-4"]).
export const run = (verb, names = [], options = {}) => request("run", { verb, names, options });

// Ask the probe, such as probe("get_parameters", {node}); its result.
export const probe = async (word, fields = {}) =>
  (await request("probe", { request: { do: word, ...fields } })).result;

// Subscribe to topics (rates), an echo {topic} or a plot {topic, field}; call the result to end it.
// The subscriptions of several panels are counted, and sent again after a lost connection.
export function subscribe(word, fields = {}) {
  const key = JSON.stringify([word, fields]);
  const subscription = subscriptions.get(key) ?? { word, fields, count: 0 };
  subscriptions.set(key, subscription);
  if (++subscription.count === 1) sendSubscription(subscription, true);
  let isOver = false;
  return () => {
    if (isOver) return;
    isOver = true;
    if (--subscription.count === 0) {
      subscriptions.delete(key);
      sendSubscription(subscription, false);
    }
  };
}

function sendSubscription(subscription, on) {
  const { word, fields } = subscription;
  request(word, { ...fields, on }).catch(() => {}); // it is sent again with the link
}

// Connect; the promise is fulfilled with the first processes, or when there will be none for now.
export function start() {
  const frozen = document.getElementById("frozen");
  if (frozen) {
    for (const message of JSON.parse(frozen.textContent)) apply(message);
    link.state = "frozen";
    link.since = hello.value?.frozen?.made ?? 0;
    return Promise.resolve();
  }
  connect();
  setInterval(checkSilence, 1000);
  document.addEventListener("visibilitychange", () => document.hidden || checkSilence());
  return new Promise((resolve) => (hasBegun = resolve));
}

function connect() {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  socket = new WebSocket(`${scheme}://${location.host}/feed`);
  socket.onopen = opened;
  socket.onmessage = (event) => received(JSON.parse(event.data));
  socket.onclose = closed;
}

// The key of the feed comes with the token of the link. Other pages of this address, and a reload,
// find it in the storage, which belongs to this port; a cookie would go to every port.
function feedKey() {
  const given = document.querySelector("meta[name=feed-key]")?.content;
  try {
    if (given) localStorage.setItem(KEY, given);
    return given || localStorage.getItem(KEY);
  } catch {
    return given;
  }
}

function opened() {
  receivedAt = Date.now();
  failures = 0;
  const after = log.last;
  request("open", { key: feedKey(), after, server: hello.value?.server ?? null }).catch(() => {});
  for (const subscription of subscriptions.values()) sendSubscription(subscription, true);
}

function received(message) {
  receivedAt = Date.now();
  if (!("event" in message)) {
    waiting.get(message.id)?.(message);
    waiting.delete(message.id);
    return;
  }
  if (message.event === "hello" && link.state !== "ended") link.state = "open";
  apply(message);
  if (message.event === "processes") hasBegun();
}

function closed(event) {
  hasBegun();
  for (const resolve of waiting.values()) {
    resolve({ ok: false, error: { code: "closed", message: LOST } });
  }
  waiting.clear();
  if (link.state === "ended") return;
  if (link.state !== "lost") link.since = Date.now() / 1000;
  link.state = "lost";
  link.text =
    event.code === 4403
      ? "The server refuses this page. Open the link that the launcher has printed."
      : "The connection to the launcher is lost.";
  setTimeout(connect, RETRY_MS[Math.min(failures++, RETRY_MS.length - 1)]);
}

// A laptop that slept may hold a connection that is dead without knowing it.
function checkSilence() {
  if (socket?.readyState !== WebSocket.OPEN || Date.now() - receivedAt <= SILENT_MS) return;
  // Its own end may come much later, and must not make a second connection then.
  socket.onclose = socket.onmessage = null;
  socket.close();
  closed({ code: 0 });
}
