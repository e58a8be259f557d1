// The picture of the graph, drawn by ECharts. One unit of a position is a pixel at zoom 1.
//
// ECharts fits the bounding box of all positions into the series, so the picture would move when a
// node comes. Two invisible corners far outside keep the box, and so the scale, the same.
// Strokes are `non-scaling-stroke` in graph.css: ECharts would draw the sides of a wide box
// thicker.
// It divides widths by the scale of what it draws, hence the factors below.

const FAR = 20000;
const LEAST_ZOOM = 0.02;
const FONT = 12;
const LEAST_FONT = 4.5;
const EDGE_LETTER = 6; // width of a letter on an edge, with some room

const colour = (name) => getComputedStyle(document.body).getPropertyValue(`--${name}`).trim();

function colours() {
  const names = ["accent", "surface", "ground", "line", "text", "muted", "bad", "idle"];
  return Object.fromEntries(names.map((name) => [name, colour(name)]));
}

export class GraphChart {
  constructor(echarts, element, onPick) {
    this.chart = echarts.init(element, null, { renderer: "svg" });
    this.element = element;
    this.zoom = 1;
    this.center = [0, 0];
    this.drawn = null;
    this.chart.on("click", (event) => {
      if (event.dataType === "node" && event.data.item) onPick(event.data.item);
    });
    this.chart.getZr().on("click", (event) => event.target || onPick(null));
    this.chart.on("graphroam", () => this.roamed());
  }

  dispose() {
    cancelAnimationFrame(this.frame);
    this.chart.dispose();
  }

  resize() {
    this.chart.resize();
    this.redraw();
  }

  // `what`: {items, edges, places, isTurned, note(item), chosen, isDim(item)}.
  draw(what) {
    this.drawn = what;
    this.redraw();
  }

  redraw() {
    if (!this.drawn) return;
    const before = performance.now();
    const { clientWidth: width, clientHeight: height } = this.element;
    const paint = colours();
    const series = {
      id: "graph",
      type: "graph",
      layout: "none",
      roam: true,
      nodeScaleRatio: 1,
      scaleLimit: { min: LEAST_ZOOM, max: 4 },
      animation: false,
      silent: false,
      left: width / 2 - FAR,
      top: height / 2 - FAR,
      width: 2 * FAR,
      height: 2 * FAR,
      zoom: this.zoom,
      center: this.center,
      label: this.label(paint),
      edgeSymbol: ["none", "arrow"],
      edgeSymbolSize: Math.max(2, 8 * Math.min(1, this.zoom)),
      emphasis: { disabled: true },
      select: { disabled: true },
      data: this.data(paint),
      links: this.links(paint),
    };
    this.chart.setOption({ animation: false, series: [series] });
    this.element.dataset.drawMs = (performance.now() - before).toFixed(1);
  }

  label(paint) {
    const size = FONT * this.zoom;
    return {
      show: size >= LEAST_FONT,
      fontSize: size,
      lineHeight: size * 1.25,
      color: paint.text,
      position: "inside",
      formatter: (entry) => entry.data.text ?? "",
    };
  }

  data(paint) {
    const { items, places } = this.drawn;
    const corners = [
      [-FAR, -FAR],
      [FAR, FAR],
    ].map(([x, y], index) => ({
      id: `corner ${index}`,
      x,
      y,
      symbol: "none",
      label: { show: false },
    }));
    const boxes = [];
    for (const item of items) {
      const at = places.get(item.id);
      if (at) boxes.push(this.box(item, at, paint));
    }
    return [...corners, ...this.ports(), ...boxes];
  }

  box(item, [x, y], paint) {
    const { note, chosen, isDim } = this.drawn;
    const isGone = item.state !== "running";
    const isBad = item.mismatches?.length > 0;
    const isChosen = chosen === item.id;
    const fill = { node: paint.ground, topic: paint.surface, fold: paint.line }[item.kind];
    const edge = isBad
      ? paint.bad
      : isGone
        ? paint.idle
        : item.kind === "topic"
          ? paint.idle
          : paint.accent;
    const words = note(item);
    return {
      id: item.id,
      item: item.id,
      x,
      y,
      text: words ? `${item.label}\n${words}` : item.label,
      symbol: { node: "circle", topic: "rect", fold: "roundRect" }[item.kind],
      symbolSize: [item.width, item.height],
      itemStyle: {
        color: isGone ? paint.ground : fill,
        borderColor: isChosen ? paint.accent : edge,
        borderWidth: (isChosen ? 3.5 : isBad ? 2.5 : 1.3) * this.strokeScale(item),
        borderType: isGone ? "dashed" : "solid",
        opacity: isDim(item) ? 0.2 : 1,
      },
      label: {
        color: isBad ? paint.bad : isGone ? paint.muted : paint.text,
        opacity: isDim(item) ? 0.25 : 1,
      },
    };
  }

  strokeScale(item) {
    return (Math.sqrt(item.width * item.height) / 2) * this.zoom;
  }

  // Edges begin and end at the side of a box that faces the other box.
  ports() {
    const found = new Map();
    for (const edge of this.drawn.edges) {
      const [first, second] = this.ends(edge);
      for (const port of [first, second]) if (port) found.set(port.id, port);
    }
    return [...found.values()];
  }

  ends(edge) {
    const { places, byId } = this.drawn;
    const [from, to] = [places.get(edge.from), places.get(edge.to)];
    if (!from || !to) return [null, null];
    const [a, b] = [byId.get(edge.from), byId.get(edge.to)];
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    const isAcross = this.drawn.isTurned
      ? Math.abs(dy) <= (a.height + b.height) / 2 + 4
      : Math.abs(dx) > (a.width + b.width) / 2 + 10;
    const side = isAcross ? [Math.sign(dx) || 1, 0] : [0, dy >= 0 ? 1 : -1];
    const port = (item, at, [dx, dy]) => ({
      id: `p ${dx}${dy} ${item.id}`,
      symbol: "none",
      label: { show: false },
      x: at[0] + (dx * item.width) / 2,
      y: at[1] + (dy * item.height) / 2,
    });
    return [
      port(a, from, side),
      port(
        b,
        to,
        side.map((one) => -one),
      ),
    ];
  }

  links(paint) {
    const found = [];
    for (const edge of this.drawn.edges) {
      const [first, second] = this.ends(edge);
      if (!first) continue;
      const isChosen = [edge.from, edge.to].includes(this.drawn.chosen);
      const tone = {
        bad: paint.bad,
        gone: paint.idle,
        running: isChosen ? paint.accent : paint.idle,
      };
      found.push({
        source: first.id,
        target: second.id,
        lineStyle: {
          color: tone[edge.state],
          curveness: 0,
          width: (edge.state === "bad" ? 3.5 : isChosen ? 2.5 : 1.2) * this.zoom,
          type: edge.state === "gone" ? "dashed" : "solid",
          opacity: edge.state === "gone" ? 0.6 : edge.state === "bad" || isChosen ? 1 : 0.75,
        },
        label: this.edgeLabel(edge, first, second, paint),
      });
    }
    return found;
  }

  // What is written on an edge, if it is long enough for that.
  edgeLabel(edge, first, second, paint) {
    const { edgeNote, byId } = this.drawn;
    const isBad = edge.state === "bad";
    const topic = byId.get(edge.from.startsWith("t ") ? edge.from : edge.to);
    const text = isBad ? "⚠ nothing arrives" : edgeNote(edge, topic);
    const size = (isBad ? 11 : 10) * this.zoom;
    const length = Math.hypot(second.x - first.x, second.y - first.y);
    const fits = text && size >= 5.5 && (isBad || length > text.length * EDGE_LETTER + 24);
    return fits
      ? { show: true, formatter: text, color: isBad ? paint.bad : paint.muted, fontSize: size }
      : { show: false };
  }

  roamed() {
    const option = this.chart.getModel().getSeriesByIndex(0).option;
    const before = this.zoom;
    this.zoom = option.zoom;
    this.center = option.center;
    if (before === this.zoom) return;
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(() => this.redraw());
  }

  scale(factor) {
    this.zoom = Math.min(4, Math.max(LEAST_ZOOM, this.zoom * factor));
    this.redraw();
  }

  centre(id, zoom = null) {
    const at = this.drawn?.places.get(id);
    if (!at) return;
    this.center = [...at];
    this.zoom = zoom ?? Math.max(this.zoom, 0.8);
    this.redraw();
  }

  // A large screen may show texts larger than they are elsewhere.
  most() {
    return this.element.clientWidth > 2000 ? 1.9 : 1.15;
  }

  fit() {
    const { items, places } = this.drawn ?? {};
    const shown = (items ?? []).filter((item) => places.has(item.id));
    if (!shown.length) return false;
    const edges = (axis, size) =>
      shown.flatMap((item) => {
        const at = places.get(item.id)[axis];
        return [at - item[size] / 2, at + item[size] / 2];
      });
    const [xs, ys] = [edges(0, "width"), edges(1, "height")];
    const [left, right, top, bottom] = [
      Math.min(...xs),
      Math.max(...xs),
      Math.min(...ys),
      Math.max(...ys),
    ];
    const { clientWidth, clientHeight } = this.element;
    this.center = [(left + right) / 2, (top + bottom) / 2];
    this.zoom = Math.max(
      LEAST_ZOOM,
      Math.min(
        this.most(),
        (clientWidth - 40) / (right - left),
        (clientHeight - 40) / (bottom - top),
      ),
    );
    this.redraw();
    return true;
  }
}
