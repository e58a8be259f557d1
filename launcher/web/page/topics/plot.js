// Numeric fields of topics over the last minutes, on one time axis.

import { computed, nextTick, onMounted, onUnmounted, ref, watch } from "vue";
import { subscribe } from "page/feed.js";
import { chosen, plots, wall } from "page/store.js";
import { clock } from "page/format.js";
import { isFrozen } from "page/shared/ros.js";

const SPANS = [
  [60, "1 min"],
  [300, "5 min"],
  [600, "10 min"],
];
const DRAW_MS = 200;
const DASHES = ["solid", "dashed", "dotted"]; // besides colours
const LIGHT = ["#0f6bb3", "#b3261e", "#1a7f37", "#7b4bb3", "#8a5a00", "#00707a"];
const DARK = ["#6cb6ff", "#ff8a80", "#57c272", "#c79bff", "#e0ac4a", "#5fd0d8"];

const colour = (name) => getComputedStyle(document.body).getPropertyValue(`--${name}`).trim();
// A line does not show a single point.
const isBroken = (points) => points.length < 2 || points.some(([, value]) => value === null);
const short = (value) => (value == null ? "–" : String(Number(value.toPrecision(5))));

// `series`: ["topic\nfield", ...]. Emits "remove" with one of them.
export const Plot = {
  props: { series: { type: Array, required: true } },
  emits: ["remove"],
  setup(props) {
    const area = ref(null);
    const span = ref(60);
    const isPaused = ref(false);
    const right = ref(new Set()); // series on the second axis
    const ends = new Map(); // of the subscriptions
    let chart = null;
    let timer = null;
    let held = null; // what a pause shows
    let observer = null;

    const palette = () => (window.Quasar.Dark.isActive ? DARK : LIGHT);
    const names = computed(() =>
      props.series.map((key, index) => {
        const [topic, field] = key.split("\n");
        return { key, topic, field, label: `${topic} ${field}`, index };
      }),
    );
    const tone = (index) => palette()[index % palette().length];
    const dash = (index) => DASHES[Math.floor(index / LIGHT.length) % DASHES.length];
    const last = (key) => short(plots.get(key)?.at(-1)?.[1]);

    watch(
      () => [...props.series],
      (now) => {
        for (const key of now) {
          if (ends.has(key) || isFrozen.value) continue;
          const [topic, field] = key.split("\n");
          ends.set(key, subscribe("plot", { topic, field }));
        }
        for (const [key, end] of [...ends]) {
          if (now.includes(key)) continue;
          end();
          ends.delete(key);
          plots.delete(key);
        }
        soon();
      },
      { immediate: true },
    );

    const newest = () =>
      Math.max(wall.value, ...props.series.map((key) => plots.get(key)?.at(-1)?.[0] ?? 0));
    const state = () => ({
      end: newest(),
      points: new Map(props.series.map((key) => [key, plots.get(key) ?? []])),
    });

    function option() {
      const { end, points } = isPaused.value && held ? held : state();
      const from = end - span.value;
      const paint = { text: colour("muted"), line: colour("line"), accent: colour("accent") };
      const axis = {
        type: "value",
        scale: true,
        axisLabel: { color: paint.text, fontSize: 11 },
        splitLine: { lineStyle: { color: paint.line, opacity: 0.6 } },
      };
      return {
        animation: false,
        grid: { left: 8, right: 12, top: 14, bottom: 8, containLabel: true },
        tooltip: {
          trigger: "axis",
          renderMode: "richText",
          confine: true,
          backgroundColor: colour("surface"),
          borderColor: paint.line,
          textStyle: { color: colour("text"), fontSize: 12 },
          formatter: (all) => tooltip(all),
        },
        dataZoom: [{ id: "zoom", type: "inside", xAxisIndex: 0, filterMode: "none" }],
        xAxis: {
          type: "time",
          min: from * 1000,
          max: end * 1000,
          splitNumber: 5,
          axisLabel: {
            color: paint.text,
            fontSize: 11,
            hideOverlap: true,
            formatter: (ms) => clock(ms / 1000),
          },
          axisLine: { lineStyle: { color: paint.line } },
        },
        yAxis: [axis, { ...axis, splitLine: { show: false }, show: right.value.size > 0 }],
        series: names.value.map(({ key, label, index }) => ({
          id: key,
          name: label,
          type: "line",
          showSymbol: isBroken(points.get(key) ?? []),
          symbolSize: 4,
          sampling: "minmax",
          yAxisIndex: right.value.has(key) ? 1 : 0,
          lineStyle: { color: tone(index), width: 1.8, type: dash(index) },
          itemStyle: { color: tone(index) },
          data: (points.get(key) ?? [])
            .filter(([time]) => time >= from - 5)
            .map(([time, value]) => [time * 1000, value]),
          markLine: index === 0 && chosen.moment ? moment(paint) : { data: [] },
        })),
      };
    }
    const moment = (paint) => ({
      symbol: "none",
      silent: true,
      animation: false,
      lineStyle: { color: paint.accent, type: "dashed" },
      label: { formatter: () => clock(chosen.moment), color: paint.accent, fontSize: 11 },
      data: [{ xAxis: chosen.moment * 1000 }],
    });
    const tooltip = (all) =>
      [
        clock(all[0].value[0] / 1000, true),
        ...all.map((one) => `${one.seriesName}  ${short(one.value[1])}`),
      ]
        .join("\n")
        .replace(/[{}]/g, "·");

    function draw() {
      timer = null;
      chart?.setOption(option(), { replaceMerge: ["series"] });
    }
    function soon() {
      timer ??= setTimeout(draw, DRAW_MS);
    }
    const pause = (on) => {
      held = on ? state() : null;
      isPaused.value = on;
    };
    const swap = (key) => {
      const now = new Set(right.value);
      if (!now.delete(key)) now.add(key);
      right.value = now;
    };
    const whole = () =>
      chart?.dispatchAction({ type: "dataZoom", dataZoomId: "zoom", start: 0, end: 100 });
    const setSpan = (value) => {
      span.value = value;
      whole();
    };

    onMounted(async () => {
      const { echarts } = await import("echarts");
      if (!area.value) return;
      chart = echarts.init(area.value, null, { renderer: "canvas" });
      observer = new ResizeObserver(() => chart.resize());
      observer.observe(area.value);
      draw();
    });
    onUnmounted(() => {
      clearTimeout(timer);
      observer?.disconnect();
      chart?.dispose();
      chart = null;
      for (const [key, end] of ends) {
        end();
        plots.delete(key);
      }
    });
    watch([plots, wall], () => isPaused.value || soon());
    watch([span, right, isPaused, () => chosen.moment], soon);
    watch(
      () => window.Quasar.Dark.isActive,
      () => nextTick(soon),
    );
    watch(
      () => chosen.moment,
      (at) => {
        if (!at) return;
        const needed = SPANS.find(([seconds]) => newest() - at < seconds);
        if (needed && needed[0] > span.value) span.value = needed[0];
      },
      { immediate: true },
    );
    return {
      area,
      SPANS,
      span,
      setSpan,
      isPaused,
      pause,
      names,
      tone,
      dash,
      last,
      right,
      swap,
      whole,
      isFrozen,
    };
  },
  template: `
    <section class="plot card" aria-label="Plot" data-plots>
      <div class="panel-bar">
        <q-btn-toggle :model-value="span" dense no-caps unelevated toggle-color="primary"
                      toggle-text-color="on-accent" padding="1px 9px"
                      :options="SPANS.map(([value, label]) => ({ value, label }))"
                      @update:model-value="setSpan" />
        <q-btn v-if="!isFrozen" flat dense no-caps :icon="isPaused ? 'play_arrow' : 'pause'"
               :label="isPaused ? 'Continue' : 'Pause'" data-action="pause-plot"
               @click="pause(!isPaused)" />
        <q-btn flat dense no-caps icon="zoom_out_map" label="Whole" @click="whole" />
        <span v-for="one in names" :key="one.key" class="series"
              :data-series="one.topic + ' ' + one.field">
          <span class="series-line"
                :style="{ borderTop: '3px ' + dash(one.index) + ' ' + tone(one.index) }"
                aria-hidden="true"></span>
          <span>{{ one.topic }} <b>{{ one.field }}</b></span>
          <span class="mono" data-last>{{ last(one.key) }}</span>
          <button type="button" class="tree-plot" :aria-pressed="right.has(one.key)"
                  :aria-label="'Axis of ' + one.label" @click="swap(one.key)">
            {{ right.has(one.key) ? "right" : "left" }}
          </button>
          <q-btn flat round dense size="xs" icon="close" :aria-label="'Remove ' + one.label"
                 @click="$emit('remove', one.key)" />
        </span>
      </div>
      <div ref="area" class="plot-area" role="img"
           :aria-label="'Plot of ' + names.map((one) => one.label).join(', ')"></div>
    </section>`,
};
