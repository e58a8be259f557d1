// The panel timeline: what happened when, as lanes and as a list of sentences.

import { computed, onMounted, onUnmounted, reactive, ref, watch } from "vue";
import {
  chosen, expectations, hello, link as connection, plan, processes, runEvents, wall,
} from "page/store.js";
import { clock } from "page/format.js";
import { shapeAt } from "page/timeline/marks.js";
import { lastAddress, link } from "page/shared/address.js";
import { TimelineChart } from "page/timeline/chart.js";
import { allEvents, lanesOf } from "page/timeline/lanes.js";
import { SearchField } from "page/shared/search_field.js";
import { WindowList } from "page/shared/window_list.js";

const LEAST_S = 0.05; // of the shown range
const MINUTE_S = 60;

const LEGEND = [
  ["start", "good", "start"],
  ["end", "muted", "end"],
  ["crash", "bad", "failure"],
  ["signal", "warn", "signal"],
  ["asked", "accent", "request"],
  ["ready", "good", "ready"],
  ["alarm", "bad", "alarm"],
  ["fault", "bad", "fault"],
  ["healed", "good", "healed"],
  ["change", "accent", "reload, host"],
  ["snapshot", "accent", "snapshot"],
  ["expected", "good", "expectation"],
  ["unmet", "bad", "not met"],
  ["file", "accent", "launch file"],
  ["stop", "warn", "run stops"],
];

const LEGEND_WORDS = new Map(LEGEND.map(([shape, , word]) => [shape, word]));

const range = reactive({ mode: "all", from: 0, to: 1 }); // mode: all, minute or free
const search = ref("");

// The end of what is known: now, or when the run or the connection ended.
const nowOf = () => {
  if (connection.state === "open" || connection.state === "connecting") return wall.value;
  return Math.max(wall.value, hello.value?.frozen ? 0 : connection.since || 0);
};

function useRange(events) {
  const now = computed(nowOf);
  const begin = computed(() => {
    const first = events.value[0]?.wall ?? now.value;
    return Math.min(hello.value?.run.started_wall_s ?? first, first);
  });
  const end = computed(() => Math.max(now.value, events.value.at(-1)?.wall ?? 0));
  const bounds = computed(() => {
    if (range.mode === "minute") return { from: end.value - MINUTE_S, to: end.value + 1 };
    if (range.mode === "free") return { from: range.from, to: range.to };
    // The end moves in steps, so that not everything is drawn anew each second.
    const size = end.value - begin.value;
    const step = 2 ** Math.ceil(Math.log2(Math.max(1, size / 32)));
    const to = begin.value + Math.ceil((size * 1.01 + 0.5) / step) * step;
    return { from: begin.value - Math.max(0.5, step * 0.6), to };
  });
  const zoom = (factor, at) => {
    const { from, to } = bounds.value;
    const middle = at ?? (from + to) / 2;
    const most = (end.value - begin.value) * 4 + MINUTE_S;
    const size = Math.min(most, Math.max(LEAST_S, (to - from) * factor));
    const start = middle - ((middle - from) / (to - from)) * size;
    Object.assign(range, { mode: "free", from: start, to: start + size });
  };
  const pan = (by) => {
    const { from, to } = bounds.value;
    Object.assign(range, { mode: "free", from: from + by, to: to + by });
  };
  // Make sure that a time is in view.
  const show = (time) => {
    const { from, to } = bounds.value;
    if (time < from || time > to) pan(time - (from + to) / 2);
  };
  return { now, bounds, zoom, pan, show, range };
}

export default {
  components: { SearchField, TimelineChart, WindowList },
  setup() {
    const list = ref(null);
    const picked = ref(null);
    const isFollowing = ref(true);
    const events = computed(() =>
      allEvents(runEvents.value, plan.value, expectations.value, hello.value?.run.started_wall_s ?? 0),
    );
    const lanes = computed(() => lanesOf(events.value, processes.value, wall.value));
    const view = useRange(events);
    const found = computed(() => {
      const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      if (!words.length) return events.value;
      return events.value.filter((one) => {
        const word = LEGEND_WORDS.get(one.shape) ?? ""; // "not met" finds what has its mark
        const all = `${one.process ?? ""} ${one.kind} ${word} ${one.text}`.toLowerCase();
        return words.every((word) => all.includes(word));
      });
    });
    const version = ref(0);
    watch(found, () => version.value++);
    const pick = (event) => {
      picked.value = event;
      chosen.moment = event.wall;
      view.show(event.wall);
      if (found.value.includes(event)) list.value?.reveal(event.key);
    };
    const setMoment = (time) => {
      picked.value = null;
      chosen.moment = time;
      const next = found.value.find((one) => one.wall >= time);
      if (next) list.value?.reveal(next.key);
    };
    watch(
      () => chosen.moment,
      (time) => time !== null && view.show(time), // it may come from outside
    );
    // Events are counted anew when older ones come in between.
    const pickedKey = computed(() => {
      const one = picked.value;
      const isSame = (other) =>
        other.wall === one.wall && other.process === one.process && other.text === one.text;
      return one ? (events.value.find(isSame)?.key ?? null) : null;
    });
    const keys = {
      "+": () => view.zoom(0.7),
      "-": () => view.zoom(1.4),
      ArrowLeft: () => view.pan((view.bounds.value.from - view.bounds.value.to) / 8),
      ArrowRight: () => view.pan((view.bounds.value.to - view.bounds.value.from) / 8),
      a: () => (range.mode = "all"),
      l: () => (range.mode = "minute"),
    };
    const pressed = (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || !keys[event.key]) return;
      if (event.target.closest?.("input, textarea, [role=tab]")) return;
      keys[event.key]();
      event.preventDefault();
    };
    onMounted(() => {
      window.addEventListener("keydown", pressed);
      if (chosen.moment !== null) view.show(chosen.moment);
    });
    onUnmounted(() => window.removeEventListener("keydown", pressed));
    // Only what there is: [shape, tone, word].
    const legend = computed(() => {
      const shapes = new Set(events.value.map((one) => one.shape));
      return LEGEND.filter(([shape]) => shapes.has(shape));
    });
    const logLink = computed(() => link("log", { at: chosen.moment?.toFixed(3) }));
    return {
      ...view, list, picked, pickedKey, legend, isFollowing, events, lanes, found, version, pick,
      setMoment, search, chosen, clock, logLink, plotsLink: lastAddress("topics"), shapeAt,
      keyOf: (event) => event.key,
    };
  },
  template: `
    <div class="panel panel-full timeline-panel">
      <div class="panel-bar">
        <SearchField v-model="search" label="Filter the events" />
        <q-btn-group flat>
          <q-btn dense flat no-caps label="All" :class="{ on: range.mode === 'all' }"
                 :aria-pressed="range.mode === 'all'" data-action="all" title="All (a)"
                 @click="range.mode = 'all'" />
          <q-btn dense flat no-caps label="Last minute" :class="{ on: range.mode === 'minute' }"
                 :aria-pressed="range.mode === 'minute'" data-action="last-minute"
                 title="Last minute (l)" @click="range.mode = 'minute'" />
        </q-btn-group>
        <q-btn flat dense round icon="zoom_in" aria-label="Zoom in (+)"
               title="Zoom in (+, Ctrl and wheel)" data-action="zoom-in" @click="zoom(0.6)" />
        <q-btn flat dense round icon="zoom_out" aria-label="Zoom out (-)"
               title="Zoom out (-, Ctrl and wheel)" data-action="zoom-out" @click="zoom(1.7)" />
        <span v-if="chosen.moment !== null" class="panel-group timeline-moment" data-moment>
          <span class="mono">{{ clock(chosen.moment, true) }}</span>
          <a :href="logLink" data-action="to-log">in the log</a>
          <a :href="plotsLink" data-action="to-plots">in the plots</a>
          <q-btn flat round dense size="xs" icon="close" aria-label="Forget the moment"
                 @click="chosen.moment = null; picked = null" />
        </span>
      </div>
      <TimelineChart :lanes="lanes" :from="bounds.from" :to="bounds.to" :now="now"
                     :moment="chosen.moment"
                     :picked="pickedKey" @pick="pick" @moment="setMoment" @zoom="zoom" @pan="pan" />
      <div class="timeline-list">
        <WindowList ref="list" :rows="found" :version="version" :key-of="keyOf" :row-height="24"
                    :is-following="isFollowing"
                    label="Events" @follow="isFollowing = $event">
          <template #default="{ row }">
            <div class="event" :class="{ current: pickedKey === row.key }" :data-event="row.kind"
                 :data-of="row.process"
                 @click="pick(row)">
              <span class="line-time mono">{{ clock(row.wall, true) }}</span>
              <svg width="14" height="14" viewBox="-7 -7 14 14" :class="'mark tone-' + row.tone"
                   aria-hidden="true"><path :d="shapeAt(row.shape)" /></svg>
              <bdi v-if="row.process" class="event-name" dir="auto">{{ row.process }}</bdi>
              <bdi class="event-text" dir="auto">{{ row.text.slice(0, 1000) }}</bdi>
              <a class="event-log" :href="'#/log?at=' + row.wall.toFixed(3)"
                 data-action="event-to-log" @click.stop="chosen.moment = row.wall">in the log</a>
            </div>
          </template>
        </WindowList>
        <div v-if="!found.length"
             class="app-empty log-empty">{{ events.length
               ? "No event matches the filter." : "There are no events yet." }}</div>
      </div>
      <div class="log-foot muted"><span
           data-count>{{ found.length === events.length
              ? events.length : found.length + " of " + events.length }} events</span>
        <span class="legend" aria-hidden="true"><span v-for="[shape, tone, word] in legend"><svg
             width="12" height="12" viewBox="-7 -7 14 14" :class="'mark tone-' + tone"><path
             :d="shapeAt(shape)" /></svg>{{ word }}</span></span>
      </div>
    </div>`,
};
