// The launch file as a tree: what the server found in it, or the plain list of its processes.

const ICONS = {
  scope: "folder",
  argument: "tune",
  process: "memory",
  node: "memory",
  group: "folder",
  include: "description",
  timer: "timer",
  skipped: "block",
  log: "chat",
  event: "bolt",
  handler: "bolt",
  shutdown: "power_settings_new",
  load: "extension",
  container: "widgets",
  environment: "settings",
  parameter: "tune",
};

export const iconOf = (node) =>
  ICONS[node.kind] ?? (node.text.startsWith("argument ") ? "tune" : "notes");

// Nodes for q-tree: with an `id` (their path) and lower-case words for the search.
function withIds(nodes, path) {
  return nodes.map((node, index) => {
    const id = `${path}${index}`;
    const children = withIds(node.children ?? [], `${id}.`);
    const words = [node.kind, node.text, node.detail, node.place, node.name].filter(Boolean);
    return { ...node, id, children, words: words.join("\n").toLowerCase() };
  });
}

function processNode(one, all) {
  const cause = one.cause === null || one.cause === undefined ? null : all[one.cause]?.name;
  const details = [
    one.package ? `${one.package} / ${one.executable}` : (one.cmd ?? []).join(" "),
    one.time ? `after ${Number(one.time.toFixed(3))} s` : "",
    cause ? `because ${cause} has exited` : "",
    one.respawn ? "is restarted" : "",
    one.host && one.host !== "local" ? `on ${one.host}` : "",
  ];
  return {
    kind: one.skipped ? "skipped" : "process",
    text: one.label ?? one.name,
    detail: details.filter(Boolean).join(", "),
    place: null,
    name: one.name,
    children: [],
  };
}

function componentNode(one) {
  const detail = `component of ${one.package}, into ${one.container}`;
  return { kind: "load", text: one.plugin, detail, place: null, name: null, children: [] };
}

export function nodesOf(plan) {
  if (!plan) return [];
  if (plan.tree) return withIds(Array.isArray(plan.tree) ? plan.tree : [plan.tree], "");
  const processes = (plan.processes ?? []).map((one, index, all) => processNode(one, all));
  return withIds([...processes, ...(plan.loads ?? []).map(componentNode)], "");
}

export function everyId(nodes) {
  return nodes.flatMap((node) => [node.id, ...everyId(node.children)]);
}

// Rows of arguments: those that the file declares, with their values in this run.
export function argumentsOf(plan) {
  const declared = plan?.declared ?? {};
  const known = plan?.arguments ?? [];
  const names = new Set(known.map((one) => one.name));
  const others = Object.keys(declared).filter((name) => !names.has(name));
  return [...known, ...others.map((name) => ({ name, description: "", has_default: false }))].map(
    (one) => ({
      ...one,
      value: Object.hasOwn(declared, one.name) ? declared[one.name] : null,
      isChanged: one.has_default && Object.hasOwn(declared, one.name) && declared[one.name] !== one.default,
    }),
  );
}
