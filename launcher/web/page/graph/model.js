// What the graph panel shows: nodes, topics and folded namespaces as items, and edges.

export const INTERNAL = new Set(["/rosout", "/parameter_events"]);
const MOST_LETTERS = 34;
const HEIGHT = 40;
const TOPIC_WIDTH = 185; // the traffic fits in

const isHiddenTopic = (name) => /\/_/.test(name);
export const namespaceOf = (name) => name.slice(0, name.lastIndexOf("/"));

export function shortened(name) {
  if (name.length <= MOST_LETTERS) return name;
  return `${name.slice(0, 12)}…${name.slice(-(MOST_LETTERS - 13))}`;
}

const widthOf = (text) => Math.min(text.length, MOST_LETTERS) * 7 + 30;

// Namespaces with at least two nodes below them: [{name, count}], outer ones first.
export function namespaces(graph) {
  const counts = new Map();
  for (const node of graph.nodes) {
    if (node.hidden) continue;
    for (let space = namespaceOf(node.name); space; space = namespaceOf(space)) {
      counts.set(space, (counts.get(space) ?? 0) + 1);
    }
  }
  return [...counts]
    .filter(([, count]) => count > 1)
    .map(([name, count]) => ({ name, count }))
    .sort((a, b) => a.name.localeCompare(b.name));
}

function foldOf(name, folded) {
  let found = null;
  for (let space = namespaceOf(name); space; space = namespaceOf(space)) {
    if (folded.has(space)) found = space;
  }
  return found;
}

// The sentence of a mismatch, and what to do.
export function sentence(one) {
  const why = one.policies.map((p) => `${p.policy}: offered ${p.offered}, asked for ${p.asked}`);
  const from = one.publishers.join(", ");
  return `${one.subscription} receives nothing from ${from} on ${one.topic} (${why.join("; ")})`;
}

export const repairs = (one) => [...new Set(one.policies.map((p) => p.repair).filter(Boolean))];

// {items: [{id, kind, name, ...}], edges: [{from, to, topic, state}], byId}.
export function picture(graph, options) {
  const topics = graph.topics.filter(
    (one) =>
      (options.internal || !INTERNAL.has(one.name)) &&
      (options.hidden || !isHiddenTopic(one.name)) &&
      (options.leaves || (one.publishers > 0 && one.subscriptions > 0)),
  );
  const nodes = graph.nodes.filter((one) => options.hidden || !one.hidden);
  const items = new Map();
  const ofNode = new Map(); // node -> id of its item
  for (const node of nodes) {
    const space = foldOf(node.name, options.folded);
    const id = space === null ? `n ${node.name}` : `f ${space}`;
    ofNode.set(node.name, id);
    if (space === null) items.set(id, nodeItem(id, node));
    else addToFold(items, id, space, node);
  }
  const found = edgesOf(graph, topics, ofNode);
  for (const topic of topics) {
    // A topic that only one folded namespace uses is inside it.
    const users = found.users.get(topic.name) ?? new Set();
    if (users.size === 1 && [...users][0].startsWith("f ")) continue;
    const id = `t ${topic.name}`;
    items.set(id, topicItem(id, topic, graph, found.endpoints.get(topic.name) ?? []));
  }
  const edges = [...found.edges.values()].filter((one) => items.has(one.from) && items.has(one.to));
  return { items: [...items.values()], edges, byId: items };
}

function nodeItem(id, node) {
  const words = { gone: "gone", ghost: "gone (ghost)", running: "" };
  const label = shortened(node.name);
  return {
    id,
    kind: "node",
    name: node.name,
    label,
    state: node.state,
    node,
    note: words[node.state] || (node.count > 1 ? `${node.count} nodes of this name` : ""),
    width: widthOf(label) * 1.1,
    height: HEIGHT,
  };
}

function addToFold(items, id, space, node) {
  const item = items.get(id) ?? {
    id,
    kind: "fold",
    name: space,
    label: shortened(`${space}/…`),
    state: "running",
    members: [],
    width: widthOf(space) + 30,
    height: HEIGHT + 8,
  };
  item.members.push(node.name);
  const gone = (item.gone = (item.gone ?? 0) + (node.state === "running" ? 0 : 1));
  item.note = `${item.members.length} nodes${gone ? `, ${gone} gone` : ""}`;
  if (gone === item.members.length) item.state = "gone";
  else item.state = "running";
  items.set(id, item);
}

function topicItem(id, topic, graph, endpoints) {
  const label = shortened(topic.name);
  const alive = endpoints.filter((one) => !one.ghost);
  return {
    id,
    kind: "topic",
    name: topic.name,
    label,
    topic,
    endpoints,
    state: alive.length ? "running" : "gone",
    isLatched: endpoints.some(isLatching),
    mismatches: graph.mismatches.filter((one) => one.topic === topic.name),
    width: Math.max(TOPIC_WIDTH, widthOf(label)),
    height: HEIGHT,
    note: "",
  };
}

export const isLatching = (one) =>
  one.direction === "publisher" && one.durability === "TRANSIENT_LOCAL" && !one.ghost;

function edgesOf(graph, topics, ofNode) {
  const shown = new Set(topics.map((one) => one.name));
  const deaf = new Set(graph.mismatches.map((one) => `${one.subscription}\n${one.topic}`));
  const edges = new Map();
  const users = new Map();
  const endpoints = new Map();
  for (const one of graph.endpoints) {
    const node = ofNode.get(one.node);
    if (!node || !shown.has(one.topic)) continue;
    const topic = `t ${one.topic}`;
    const isPublisher = one.direction === "publisher";
    const [from, to] = isPublisher ? [node, topic] : [topic, node];
    const isBad = !isPublisher && !one.ghost && deaf.has(`${one.node}\n${one.topic}`);
    const key = `${from}\n${to}`;
    const state = isBad ? "bad" : one.ghost ? "gone" : "running";
    const before = edges.get(key)?.state;
    const keep = before === "bad" || (before === "running" && state === "gone");
    edges.set(key, { from, to, topic: one.topic, state: keep ? before : state });
    users.set(one.topic, (users.get(one.topic) ?? new Set()).add(node));
    endpoints.set(one.topic, [...(endpoints.get(one.topic) ?? []), one]);
  }
  return { edges, users, endpoints };
}

// Where the items are: {id: [x, y]}, folded namespaces in the middle of their nodes.
export function places(items, positions) {
  const found = new Map();
  for (const item of items) {
    if (item.kind === "fold") {
      const all = item.members.map((name) => positions.nodes[name]).filter(Boolean);
      const mean = (axis) => all.reduce((sum, at) => sum + at[axis], 0) / all.length;
      if (all.length) found.set(item.id, [mean(0), mean(1)]);
    } else {
      const at = positions[item.kind === "node" ? "nodes" : "topics"][item.name];
      if (at) found.set(item.id, at);
    }
  }
  return found;
}
