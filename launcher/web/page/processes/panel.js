// The panel processes: what runs, what it uses, and the buttons that start and stop it.

import {
  computed, getCurrentInstance, nextTick, onMounted, onUnmounted, reactive, ref, watch,
} from "vue";
import { chosen, processes } from "page/store.js";
import { processCount } from "page/format.js";
import { AnswerList } from "page/processes/answer_list.js";
import { link } from "page/shared/address.js";
import { ActionButtons } from "page/processes/cells.js";
import { ProcessDrawer } from "page/processes/details.js";
import { KillDialog } from "page/processes/kill_dialog.js";
import { COLUMNS, actionNamed, fitsOf, matching, sorted } from "page/processes/rows.js";
import { ProcessCards, ProcessTable } from "page/processes/table.js";
import { remember, remembered } from "page/shared/remembered.js";
import { answers, isConnected, steer } from "page/processes/steering.js";
import { SearchField } from "page/shared/search_field.js";

const NARROW = 900; // cards below this width
const WIDE = 1500; // from here on the last error has a column
const selected = reactive(new Set()); // names; they outlive a change of the panel
const search = ref("");

function useOrder() {
  const order = reactive(remembered("process-order", { by: "", isDescending: false }));
  const sort = (name) => {
    if (order.by !== name) Object.assign(order, { by: name, isDescending: false });
    else if (!order.isDescending) order.isDescending = true;
    else Object.assign(order, { by: "", isDescending: false });
    remember("process-order", order);
  };
  return { order, sort };
}

// Selection by checkbox, with Shift from the last one to this one.
function useSelection(rows) {
  let last = null;
  const pick = (name, isRange) => {
    const names = rows.value.map((row) => row.name);
    const [from, to] = [names.indexOf(last), names.indexOf(name)];
    const isOn = !selected.has(name);
    const [low, high] = isRange && from >= 0 ? [Math.min(from, to), Math.max(from, to)] : [to, to];
    const range = names.slice(low, high + 1);
    for (const one of range) isOn ? selected.add(one) : selected.delete(one);
    last = name;
  };
  const pickAll = () => {
    const names = rows.value.map((row) => row.name);
    const isAll = names.every((name) => selected.has(name));
    for (const name of names) isAll ? selected.delete(name) : selected.add(name);
  };
  watch(processes, (all) => {
    const names = new Set(all.map((row) => row.name));
    for (const name of selected) if (!names.has(name)) selected.delete(name);
  });
  return { pick, pickAll };
}

// Verbs for names: those for which it makes sense; `kill` asks first.
function useVerbs() {
  const asking = ref(null); // names that are to be killed
  const kill = () => {
    steer("kill", asking.value, { signal: "SIGKILL" });
    asking.value = null;
  };
  const act = (verb, names) => {
    const fits = actionNamed(verb).fits;
    const able = processes.value.filter((row) => names.includes(row.name) && fits(row));
    if (!able.length || !isConnected.value) return;
    if (verb === "kill") asking.value = able.map((row) => row.name);
    else steer(verb, able.map((row) => row.name));
  };
  return { asking, kill, act };
}

// Whether it has ever had a value.
function everSet(source) {
  const was = ref(false);
  watch(source, (value) => (was.value ||= value !== null));
  return was;
}

function useKeys(rows, root, selection, act, open) {
  const cursor = ref(null);
  const focused = computed(() =>
    rows.value.some((row) => row.name === cursor.value) ? cursor.value : rows.value[0]?.name,
  );
  const focus = async (name) => {
    cursor.value = name;
    await nextTick();
    root.value?.querySelector(`[data-process="${CSS.escape(name)}"]`)?.focus();
  };
  const move = (step) => {
    const names = rows.value.map((row) => row.name);
    const at = names.indexOf(focused.value) + step;
    if (names.length) focus(names[Math.max(0, Math.min(names.length - 1, at))]);
  };
  const targets = () => {
    const names = rows.value.map((row) => row.name);
    const shown = names.filter((name) => selected.has(name));
    return shown.length ? shown : [focused.value];
  };
  const toggleMute = () => {
    const names = targets();
    const isMuted = processes.value.every((row) => !names.includes(row.name) || row.muted_by_name);
    act(isMuted ? "unmute" : "mute", names);
  };
  const keys = {
    ArrowDown: () => move(1),
    ArrowUp: () => move(-1),
    Home: () => move(-Infinity),
    End: () => move(Infinity),
    " ": (event) => selection.pick(focused.value, event.shiftKey),
    Enter: () => open(focused.value),
    s: () => act("stop", targets()),
    r: () => act("restart", targets()),
    k: () => act("kill", targets()),
    m: toggleMute,
  };
  const pressed = (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !rows.value.length) return;
    if (event.target.closest?.("input:not([type=checkbox]), textarea, .q-dialog")) return;
    const isButton = event.target.closest?.("button, a, input, [role=tab]");
    if (isButton && [" ", "Enter"].includes(event.key)) return;
    if (!keys[event.key]) return;
    keys[event.key](event);
    event.preventDefault();
  };
  onMounted(() => window.addEventListener("keydown", pressed));
  onUnmounted(() => window.removeEventListener("keydown", pressed));
  return { cursor, focused };
}

export default {
  components: {
    ActionButtons, AnswerList, KillDialog, ProcessCards, ProcessDrawer, ProcessTable, SearchField,
  },
  setup() {
    const screen = getCurrentInstance().proxy.$q.screen;
    const root = ref(null);
    const opened = ref(null);
    const { order, sort } = useOrder();
    const found = computed(() => matching(processes.value, search.value));
    const rows = computed(() => sorted(found.value, order.by, order.isDescending));
    const hasHosts = computed(() => new Set(processes.value.map((row) => row.host)).size > 1);
    const isWide = computed(() => screen.width >= WIDE);
    const isShown = { host: () => hasHosts.value, error: () => isWide.value };
    const columns = computed(() => COLUMNS.filter((one) => isShown[one.name]?.() ?? true));
    const selection = useSelection(rows);
    const { asking, kill, act } = useVerbs();
    const open = (name) => (opened.value = name);
    // Templates are compiled when they are first drawn: not for the first picture.
    const wasOpened = everSet(opened);
    const wasAsked = everSet(asking);
    const { cursor, focused } = useKeys(rows, root, selection, act, open);
    // Not those that the filter hides: nobody stops what they do not see.
    const chosenRows = computed(() => rows.value.filter((row) => selected.has(row.name)));
    const toLog = () => {
      chosen.processes.clear();
      location.hash = link("log", { process: chosenRows.value.map((row) => row.name) });
    };
    return {
      root, opened, open, order, sort, rows, columns, selected, ...selection, asking, kill, act,
      cursor, focused, chosenRows, fitsOf, search, processes, processCount,
      toLog, isWide, wasOpened, wasAsked,
      hasAnswers: computed(() => answers.length > 0),
      isNarrow: computed(() => screen.width < NARROW),
    };
  },
  template: `
    <div class="panel" ref="root">
      <div class="panel-bar">
        <SearchField v-model="search" label="Filter the processes" />
        <span class="muted" data-count
          >{{ (rows.length === processes.length ? "" : rows.length + " of ")
          + processCount(processes.length) }}</span>
        <q-space />
        <span v-if="chosenRows.length" class="panel-group" data-selection>
          <b>{{ chosenRows.length }} selected</b>
          <ActionButtons :fits="fitsOf(chosenRows)" label="the selection"
                         @act="act($event, chosenRows.map((row) => row.name))" />
          <q-btn flat dense no-caps icon="subject" label="Log" @click="toLog" data-action="log" />
          <q-btn flat dense no-caps label="None" @click="selected.clear()"
                 data-action="select-none" />
        </span>
      </div>
      <component :is="isNarrow ? 'ProcessCards' : 'ProcessTable'" :rows="rows" :columns="columns"
                 :selected="selected" :cursor="focused" :order="order" :is-wide="isWide"
                 @sort="sort" @pick="pick" @pick-all="pickAll" @open="open" @act="act"
                 @focus="cursor = $event" />
      <div v-if="!rows.length" class="app-empty">{{ processes.length
        ? "No process matches the filter." : "There are no processes." }}</div>
      <AnswerList v-if="hasAnswers" />
      <div v-if="hasAnswers" class="answers-room" aria-hidden="true"></div>
      <ProcessDrawer v-if="wasOpened" :name="opened" @close="opened = null" />
      <KillDialog v-if="wasAsked" :names="asking" @cancel="asking = null" @kill="kill" />
    </div>`,
};
