// Draws the lanes as SVG: zoom with Ctrl and wheel or + and -, pan by dragging or arrows.

import { computed, onMounted, onUnmounted, ref } from "vue";
import { clock } from "page/format.js";
import { shapeAt } from "page/timeline/marks.js";
import { thinned, thinnedBars, ticks } from "page/timeline/lanes.js";

const LANE = 26;
const SPARE = 5; // lanes beyond the view that are drawn as well
const DRAG = 4; // points: less is a click
const WORDS = {
  running: "running", stopped: "stopped", failed: "ended by itself, not well",
  backoff: "waits for its restart", waiting: "waits for others", paused: "paused",
};

export const TimelineChart = {
  props: {
    lanes: { type: Array, required: true },
    from: { type: Number, required: true },
    to: { type: Number, required: true },
    now: { type: Number, required: true },
    moment: { type: Number, default: null },
    picked: { type: Number, default: null }, // key of the marked event
  },
  emits: ["pick", "moment", "zoom", "pan"],
  setup(props, { emit }) {
    const box = ref(null);
    const width = ref(600);
    const x = (time) => ((time - props.from) / (props.to - props.from)) * width.value;
    const timeAt = (clientX) => {
      const left = box.value.querySelector(".lane-plot").getBoundingClientRect().left;
      return props.from + ((clientX - left) / width.value) * (props.to - props.from);
    };
    const axis = computed(() => ticks(props.from, props.to, width.value));
    const label = (time) => clock(time, axis.value.step < 1);
    const first = ref(0); // the lanes in view: only these are drawn
    const last = ref(60);
    const look = () => {
      first.value = Math.floor(box.value.scrollTop / (LANE + 1)) - SPARE;
      last.value = Math.ceil((box.value.scrollTop + box.value.clientHeight) / (LANE + 1)) + SPARE;
    };
    const isDrawn = (index) => index >= first.value && index <= last.value;
    const bars = (lane) =>
      thinnedBars(
        lane.bars
          .map((bar) => ({
            bar,
            left: bar.from === null ? -2 : Math.max(-2, x(bar.from)),
            right: Math.min(width.value + 2, x(bar.to ?? props.now)),
          }))
          .filter((one) => one.right > 0 && one.left < width.value && one.right >= one.left)
          .map((one) => ({ ...one, width: Math.max(1, one.right - one.left) })),
      );
    const marks = (lane) => {
      const margin = ((props.to - props.from) / width.value) * 8;
      const [from, to] = [props.from - margin, props.to + margin];
      const shown = lane.marks.filter((one) => one.wall >= from && one.wall <= to);
      return thinned(shown, x);
    };
    const barText = (lane, bar) => {
      const begin = bar.from === null ? "" : ` from ${clock(bar.from)}`;
      const end = bar.to === null ? "" : ` to ${clock(bar.to)}`;
      const pid = bar.pid ? `, pid ${bar.pid}` : "";
      return `${lane.name}: ${WORDS[bar.state]}${begin}${end}${pid}`;
    };
    const markText = (mark) => `${clock(mark.wall, true)} ${mark.process ?? ""} ${mark.text}`;

    let drag = null;
    const down = (event) => {
      if (event.button === 0) drag = { from: event.clientX, last: event.clientX, hasMoved: false };
    };
    const move = (event) => {
      if (!drag) return;
      if (Math.abs(event.clientX - drag.from) > DRAG) drag.hasMoved = true;
      if (!drag.hasMoved) return;
      emit("pan", ((drag.last - event.clientX) / width.value) * (props.to - props.from));
      drag.last = event.clientX;
    };
    const up = (event) => {
      const wasClick = drag && !drag.hasMoved;
      drag = null;
      const isPlot = event.target.closest?.(".lane-plot") && !event.target.closest("[data-event]");
      if (wasClick && isPlot) emit("moment", timeAt(event.clientX));
    };
    const wheel = (event) => {
      if (event.ctrlKey || event.metaKey) {
        event.preventDefault();
        emit("zoom", event.deltaY > 0 ? 1.25 : 0.8, timeAt(event.clientX));
      } else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        event.preventDefault();
        const points = event.deltaX || event.deltaY;
        emit("pan", (points / width.value) * (props.to - props.from));
      }
    };
    const measure = () => {
      width.value = Math.max(80, box.value?.querySelector(".lane-plot")?.clientWidth ?? 600);
      look();
    };
    const observer = new ResizeObserver(measure);
    onMounted(() => {
      observer.observe(box.value);
      measure();
      box.value.addEventListener("wheel", wheel, { passive: false });
      window.addEventListener("pointermove", move);
      window.addEventListener("pointerup", up);
    });
    onUnmounted(() => {
      observer.disconnect();
      window.removeEventListener("pointermove", move);
      window.removeEventListener("pointerup", up);
    });
    return {
      box, width, x, axis, label, look, isDrawn, bars, marks, barText, markText, down, shapeAt, LANE,
    };
  },
  template: `
    <div class="timeline" ref="box" @pointerdown="down" @scroll.passive="look">
      <div class="lane lane-axis" aria-hidden="true">
        <div class="lane-name"></div>
        <svg class="lane-plot" height="22">
          <g v-for="time in axis.times" :key="time">
            <line :x1="x(time)" :x2="x(time)" y1="16" y2="22" class="tick" />
            <text :x="Math.min(width - 34, Math.max(34, x(time)))" y="12"
                  text-anchor="middle">{{ label(time) }}</text>
          </g>
        </svg>
      </div>
      <div v-for="(lane, index) in lanes" :key="lane.name" class="lane"
           :data-lane="lane.name" role="group"
           :aria-label="'Timeline of ' + lane.name">
        <div class="lane-name" :title="lane.name"><bdi dir="auto">{{ lane.name }}</bdi></div>
        <svg class="lane-plot" :height="LANE"><template v-if="isDrawn(index)">
          <line v-for="time in axis.times" :key="time" :x1="x(time)" :x2="x(time)" y1="0" :y2="LANE"
                class="grid" />
          <rect v-for="(one, place) in bars(lane)" :key="place" :class="'bar bar-' + one.bar.state"
                :data-bar="one.bar.state"
                :x="one.left" :width="one.width" :y="one.bar.state === 'running' ? 8 : 11"
                :height="one.bar.state === 'running' ? 10 : 4"
                rx="2"><title>{{ barText(lane, one.bar) }}</title></rect>
          <line v-if="moment !== null && moment >= from && moment <= to" :x1="x(moment)"
                :x2="x(moment)" y1="0" :y2="LANE" class="moment" />
          <g v-for="mark in marks(lane)" :key="mark.key" :data-event="mark.kind"
             :class="['mark', 'tone-' + mark.tone, { picked: mark.key === picked }]"
             @click="$emit('pick', mark)">
            <title>{{ markText(mark) }}</title>
            <rect :x="x(mark.wall) - 7" y="1" width="14" :height="LANE - 2" fill="transparent" />
            <path :d="shapeAt(mark.shape, x(mark.wall), LANE / 2)" />
          </g>
        </template></svg>
      </div>
    </div>`,
};
