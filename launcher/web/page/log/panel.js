// The panel log: the lines of all or some processes, with filters, jumps and neighbours.

import { computed, onMounted, onUnmounted, ref, shallowRef } from "vue";
import { chosen, log, processes } from "page/store.js";
import { LogContext } from "page/log/context.js";
import { download } from "page/log/file.js";
import { LAUNCHER, LEVELS } from "page/log/filter.js";
import { LogLine } from "page/log/line.js";
import { useLogView } from "page/log/view.js";
import { criteria, look } from "page/log/criteria.js";
import { SearchField } from "page/shared/search_field.js";
import { WindowList } from "page/shared/window_list.js";

const ROW_HEIGHT = 20;
const NOTE_MS = 4000; // how long a note is shown
const RANGES = [
  { value: "all", label: "All times" },
  { value: "60", label: "Last minute" },
  { value: "300", label: "Last 5 minutes" },
  { value: "times", label: "From … to" },
];
const TIMES = { clock: "since", since: "none", none: "clock" };
const TIME_WORDS = { clock: "wall clock", since: "since the start", none: "no times" };
const LEVEL_OPTIONS = [
  { value: "", label: "All levels" },
  ...LEVELS.slice(0, -1).map((level) => ({ value: level, label: `${level} and above` })),
  { value: "FATAL", label: "FATAL" },
];

// The processes to choose from, with the number of lines of each.
function useNames(counts) {
  const names = computed({
    get: () => [...chosen.processes],
    set: (value) => {
      chosen.processes.clear();
      for (const name of value ?? []) chosen.processes.add(name);
    },
  });
  const options = computed(() => {
    const known = processes.value.map((row) => row.name);
    const all = new Set([...known, ...counts.value.keys(), ...chosen.processes, LAUNCHER]);
    return [...all].map((name) => ({ name, count: counts.value.get(name) ?? 0 }));
  });
  const shown = computed(() => {
    if (!names.value.length) return "All processes";
    return names.value.length === 1 ? names.value[0] : `${names.value.length} processes`;
  });
  return { names, options, shown };
}

function useKeys(view, close) {
  const keys = {
    n: () => view.jumpToError(1),
    N: () => view.jumpToError(-1),
    e: () => view.jumpToError(0),
    f: () => view.follow(true),
    w: () => (look.isWrapped = !look.isWrapped),
    Escape: close,
  };
  const pressed = (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !keys[event.key]) return;
    if (event.target.closest?.("input, textarea, .q-menu")) return;
    keys[event.key]();
    event.preventDefault();
  };
  onMounted(() => window.addEventListener("keydown", pressed));
  onUnmounted(() => window.removeEventListener("keydown", pressed));
}

export default {
  components: { LogContext, LogLine, SearchField, WindowList },
  setup() {
    const list = ref(null);
    const context = shallowRef(null); // the row whose neighbours are shown
    const view = useLogView(list);
    const noError = ref(false);
    const close = () => (context.value = null);
    let hiding = 0;
    const jump = (step) => {
      clearTimeout(hiding);
      noError.value = !view.jumpToError(step);
      hiding = setTimeout(() => (noError.value = false), NOTE_MS);
    };
    useKeys({ ...view, jumpToError: jump }, close);
    const open = (row) => {
      if (String(window.getSelection())) return; // text was marked, to be copied
      view.follow(false);
      view.current.value = row;
      context.value = row;
    };
    const total = computed(() => (void log.version.value, log.rows.length));
    const isFiltered = computed(
      () => chosen.processes.size || criteria.level || criteria.text || criteria.range !== "all",
    );
    const clear = () => {
      chosen.processes.clear();
      Object.assign(criteria, { level: "", text: "", range: "all", from: "", to: "" });
    };
    return {
      ...view, ...useNames(view.counts), list, context, close, open, jump, noError, criteria, look,
      total, isFiltered, clear, ROW_HEIGHT, RANGES, LEVEL_OPTIONS, TIME_WORDS,
      keyOf: (row) => row.number,
      toMoment: (row) => row.time && (chosen.moment = row.time),
      nextTimes: () => (look.times = TIMES[look.times]),
      save: () => download(view.rows.value),
      number: (value) => value.toLocaleString("en"),
    };
  },
  template: `
    <div class="panel panel-full log-panel">
      <div class="panel-bar log-bar">
        <SearchField v-model="criteria.text" label="Search the log" :is-wrong="problem !== ''"
                     :placeholder="criteria.isRegex ? 'Expression (/)' : 'Filter (/)'">
          <q-btn flat dense no-caps size="sm" label=".*" :class="{ on: criteria.isRegex }"
                 data-action="regex" :aria-pressed="criteria.isRegex"
                 aria-label="Regular expression" title="Regular expression"
                 @click="criteria.isRegex = !criteria.isRegex" />
          <q-btn flat dense no-caps size="sm" label="Aa" :class="{ on: criteria.isExact }"
                 data-action="case" :aria-pressed="criteria.isExact"
                 aria-label="Upper and lower case differ" title="Upper and lower case differ"
                 @click="criteria.isExact = !criteria.isExact" />
        </SearchField>
        <q-select dense outlined options-dense multiple emit-value v-model="names"
                  :options="options"
                  option-value="name" option-label="name" :display-value="shown" class="log-names"
                  aria-label="Processes" data-filter="process" popup-content-class="log-menu">
          <template #option="{ itemProps, opt, selected, toggleOption }">
            <q-item v-bind="itemProps" :data-option="opt.name">
              <q-item-section side><q-checkbox dense size="xs" :model-value="selected"
                   @update:model-value="toggleOption(opt)" /></q-item-section>
              <q-item-section><bdi dir="auto">{{ opt.name }}</bdi></q-item-section>
              <q-item-section side class="mono">{{ number(opt.count) }}</q-item-section>
            </q-item>
          </template>
        </q-select>
        <q-select dense outlined options-dense emit-value map-options v-model="criteria.level"
                  :options="LEVEL_OPTIONS"
                  aria-label="Minimum level" data-filter="level" class="log-level" />
        <q-select dense outlined options-dense emit-value map-options v-model="criteria.range"
                  :options="RANGES"
                  aria-label="Times" data-filter="range" class="log-range" />
        <span v-if="criteria.range === 'times'" class="panel-group">
          <input type="time" step="1" v-model="criteria.from" aria-label="From" data-filter="from"
                 class="time-input">
          <span class="muted">to</span>
          <input type="time" step="1" v-model="criteria.to" aria-label="To" data-filter="to"
                 class="time-input">
        </span>
        <q-btn v-if="isFiltered" flat dense round icon="filter_alt_off"
               aria-label="Show all lines" title="Show all lines" data-action="clear-filters"
               @click="clear" />
        <q-space />
        <span class="panel-group">
          <q-btn flat dense round icon="first_page" aria-label="First error (e)"
                 title="First error (e)" data-action="first-error" @click="jump(0)" />
          <q-btn flat dense round icon="keyboard_arrow_up" aria-label="Error before (N)"
                 title="Error before (N)" data-action="previous-error" @click="jump(-1)" />
          <q-btn flat dense round icon="keyboard_arrow_down" aria-label="Next error (n)"
                 title="Next error (n)" data-action="next-error" @click="jump(1)" />
          <q-btn flat dense round icon="wrap_text" :class="{ on: look.isWrapped }"
                 :aria-pressed="look.isWrapped" aria-label="Wrap lines (w)" title="Wrap lines (w)"
                 data-action="wrap" @click="look.isWrapped = !look.isWrapped" />
          <q-btn flat dense round icon="schedule" :class="{ on: look.times !== 'none' }"
                 :aria-label="'Times: ' + TIME_WORDS[look.times]"
                 :title="'Times: ' + TIME_WORDS[look.times]" data-action="times"
                 @click="nextTimes" />
          <q-btn flat dense round icon="label_off" :class="{ on: look.isShort }"
                 :aria-pressed="look.isShort" aria-label="Without level, time stamp and node"
                 title="Lines without the level, time stamp and node that ROS writes before them"
                 data-action="short" @click="look.isShort = !look.isShort" />
          <q-btn flat dense round icon="palette" :class="{ on: look.withColours }"
                 :aria-pressed="look.withColours" aria-label="Colours" title="Colours"
                 data-action="colours" @click="look.withColours = !look.withColours" />
          <q-btn flat dense round icon="download" aria-label="Download the shown lines"
                 title="Download the shown lines" data-action="download" @click="save" />
        </span>
      </div>
      <div v-if="problem" class="bad log-problem" role="alert" data-problem
           dir="auto">{{ problem }}</div>
      <div class="log-body">
        <WindowList ref="list" :rows="rows" :version="version" :key-of="keyOf"
                    :row-height="ROW_HEIGHT"
                    :is-following="isFollowing" :is-wrapped="look.isWrapped" label="Lines"
                    @follow="follow">
          <template #default="{ row }">
            <LogLine :row="row" :times="look.times" :with-colours="look.withColours"
                     :is-wrapped="look.isWrapped" :is-short="look.isShort"
                     :is-current="current === row" @click="open(row)" />
          </template>
        </WindowList>
        <div v-if="!rows.length && !problem"
             class="app-empty log-empty">{{ total
               ? "No line matches the filters." : "There are no lines yet." }}</div>
        <q-btn v-if="!isFollowing" class="log-go-on" no-caps unelevated dense icon="arrow_downward"
               data-action="follow"
               :label="newLines ? number(newLines) + (newLines === 1 ? ' new line' : ' new lines')
                 : 'To the end'"
               @click="follow(true)" />
      </div>
      <LogContext v-if="context" :row="context" :look="look" @close="close" @pick="toMoment" />
      <div class="log-foot muted" role="status">
        <span
              data-shown-lines>{{ rows.length === total ? number(total)
                : number(rows.length) + " of " + number(total) }} lines</span>
        <span data-follow-state>{{ isFollowing ? "follows the end" : "paused" }}</span>
        <span v-if="noError" data-no-error>no error there</span>
      </div>
    </div>`,
};
