// Positions by ECharts' force layout, where the server has no Graphviz. Known ones are kept.

const SIZE = 1000;

const idOf = (kind, name) => `${kind} ${name}`;

// {nodes: {name: [x, y]}, topics: {name: [x, y]}} of a graph; `known` has the earlier ones.
export function forcePositions(echarts, graph, known) {
  const all = [
    ...graph.nodes.map((one) => ["nodes", one.name]),
    ...graph.topics.map((one) => ["topics", one.name]),
  ];
  if (all.every(([kind, name]) => known[kind][name])) return known;
  const element = document.createElement("div");
  const chart = echarts.init(element, null, { renderer: "svg", width: SIZE, height: SIZE });
  const data = all.map(([kind, name]) => {
    const at = known[kind][name];
    return { id: idOf(kind, name), ...(at ? { x: at[0], y: at[1], fixed: true } : {}) };
  });
  const links = graph.endpoints.map((one) => {
    const ends = [idOf("nodes", one.node), idOf("topics", one.topic)];
    const [source, target] = one.direction === "publisher" ? ends : ends.reverse();
    return { source, target };
  });
  chart.setOption({
    animation: false,
    series: [
      {
        type: "graph",
        layout: "force",
        data,
        links,
        force: { repulsion: 500, edgeLength: 90, gravity: 0.08, layoutAnimation: false },
      },
    ],
  });
  const laid = chart.getModel().getSeriesByIndex(0).getData();
  const found = { nodes: { ...known.nodes }, topics: { ...known.topics } };
  all.forEach(([kind, name], index) => {
    const at = laid.getItemLayout(index);
    if (at && !known[kind][name]) found[kind][name] = [at[0] * 1.6, at[1]];
  });
  chart.dispose();
  return found;
}
