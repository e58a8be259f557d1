// The frame: header with the state of the run, navigation, one panel at a time.

import { computed, defineAsyncComponent, onMounted, onUnmounted, ref, watchEffect } from "vue";
import { faults, hello, link, notices, processes } from "page/store.js";
import { UnmetList } from "page/expectations/unmet.js";
import { KeyList } from "page/key_list.js";
import { toggleTheme } from "page/theme.js";
import { clock, day, duration } from "page/format.js";
import { isReported } from "page/faults/order.js";
import { lastAddress } from "page/shared/address.js";

const loadPanel = (name) => import(`page/${name}/panel.js`);
const SILENT_S = 4; // it sends the state of the processes once a second
const PRELOAD_MS = 1000;

// Name in the address, label, icon, and the module of each panel.
const PANELS = [
  ["processes", "Processes", "memory"],
  ["log", "Log", "subject"],
  ["graph", "Graph", "hub"],
  ["topics", "Topics", "show_chart"],
  ["parameters", "Parameters", "tune"],
  ["services", "Services", "swap_horiz"],
  ["timeline", "Timeline", "timeline"],
  ["plan", "Plan", "account_tree"],
  ["faults", "Faults", "report"],
].map(([name, label, icon], index) => ({
  name,
  label,
  icon,
  key: String(index + 1),
  component: defineAsyncComponent(() => loadPanel(name)),
}));

// Also the panels that nobody has opened yet, for when the server is gone.
async function loadAll() {
  if (link.state !== "open") return;
  await Promise.allSettled([...PANELS.map((one) => loadPanel(one.name)), import("echarts")]);
  document.body.dataset.loaded = "all";
}

const fromHash = () => {
  const name = location.hash.replace(/^#\/?/, "").split("?")[0];
  return PANELS.find((one) => one.name === name) ?? PANELS[0];
};

// Escape empties a search field first, and leaves it then.
function leave(field) {
  if (!field.value) {
    field.blur();
    return;
  }
  field.value = "";
  field.dispatchEvent(new Event("input", { bubbles: true }));
}

// What is said of a report, by the message hello.
function reportOf({ frozen, ended }) {
  if (!frozen) return null;
  const made = `${day(frozen.made)} ${clock(frozen.made)}`;
  const state = "Processes, graph and topics are shown as they were before the run was stopped.";
  const note = [ended?.text, frozen.report ? state : ""].filter(Boolean).join(" ");
  if (!Number.isInteger(frozen.report?.exit_code)) return { made, note };
  return frozen.report.exit_code === 0
    ? { made, note, verdict: "passed", icon: "check_circle", tone: "good" }
    : { made, note, verdict: "failed", icon: "cancel", tone: "bad" };
}

export const App = {
  components: { KeyList, UnmetList },
  setup() {
    const panel = ref(fromHash().name);
    const current = computed(() => PANELS.find((one) => one.name === panel.value));
    const isDrawerOpen = ref(false);
    const isHelpOpen = ref(null); // null: it was never open
    const follow = () => (panel.value = fromHash().name);
    const show = (name) => (location.hash = lastAddress(name));
    const title = computed(() => hello.value?.run.target.split("/").pop() ?? "launcher");
    // A report has another title, with its result.
    watchEffect(() => {
      if (hello.value && !hello.value.frozen) document.title = `${title.value} - launcher`;
    });
    const counts = computed(() => {
      const running = processes.value.filter((row) => row.state === "RUNNING").length;
      const were = hello.value?.frozen ? "were running" : "running";
      return `${running} of ${processes.value.length} ${were}`;
    });
    // A report of a run that was not watched has none.
    const panels = computed(() =>
      PANELS.filter((one) => one.name !== "faults" || faults.value || !hello.value?.frozen),
    );
    const activeFaults = computed(
      () => [...(faults.value?.values() ?? [])].filter(isReported).length,
    );
    const faultsText = computed(() => `${activeFaults.value} ${activeFaults.value === 1 ? "fault" : "faults"}`);
    const report = computed(() => reportOf(hello.value ?? {}));
    const banner = computed(() => {
      if (link.state === "open" && link.silent_s > SILENT_S) {
        return `The launcher has sent nothing for ${duration(link.silent_s)}: it may be suspended.`;
      }
      if (link.state === "lost") return `${link.text} Trying again…`;
      if (link.state === "ended") {
        return `${link.text} This is its last state, of ${clock(link.since)}.`;
      }
      return "";
    });
    const pressed = (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.target.closest?.("input, textarea, [contenteditable]")) {
        if (event.key === "Escape" && event.target.closest("[data-search]")) leave(event.target);
        return;
      }
      const chosen = panels.value.find((one) => one.key === event.key);
      if (chosen) show(chosen.name);
      else if (event.key === "t") toggleTheme();
      else if (event.key === "?") isHelpOpen.value = true;
      else if (event.key === "/") {
        document.querySelector("input[data-search], [data-search] input")?.focus();
      } else return;
      event.preventDefault();
    };
    onMounted(() => {
      if (location.search) history.replaceState(null, "", location.pathname + location.hash);
      window.addEventListener("hashchange", follow);
      window.addEventListener("keydown", pressed);
      // Without a server, panels that nobody has opened yet could not be fetched any more.
      setTimeout(loadAll, PRELOAD_MS);
    });
    onUnmounted(() => {
      window.removeEventListener("hashchange", follow);
      window.removeEventListener("keydown", pressed);
    });
    return {
      panels, panel, current, activeFaults, faultsText, isDrawerOpen, isHelpOpen, show, title, counts, report, banner,
      hello, link,
      notices, toggleTheme, clock,
    };
  },
  template: `
    <q-layout view="hHh Lpr lFf">
      <q-header class="app-header">
        <q-toolbar>
          <q-btn flat round dense icon="menu" class="lt-md" aria-label="Panels"
                 @click="isDrawerOpen = !isDrawerOpen" />
          <q-toolbar-title class="app-title">
            <span>{{ title }}</span>
            <span class="app-counts" v-if="hello">{{ counts }}<a v-if="activeFaults"
                  class="app-faults lt-md" href="#/faults">{{ faultsText }}</a></span>
          </q-toolbar-title>
          <span v-if="hello?.read_only && !report" class="tag">read only</span>
          <span v-if="report" class="app-report" role="status" data-report>
            <template v-if="report.verdict"><q-icon :name="report.icon" :class="report.tone" />
              <b :class="report.tone">{{ report.verdict }}</b></template>
            <span>report<span class="gt-xs"> of {{ report.made }}</span></span>
          </span>
          <span v-else class="app-link" :data-state="link.state" role="status"
            >{{ link.state }}</span>
          <q-btn flat round dense icon="contrast" aria-label="Light or dark (t)"
                 @click="toggleTheme" />
          <q-btn flat round dense icon="keyboard" aria-label="Keys (?)" class="gt-sm"
                 @click="isHelpOpen = true" />
        </q-toolbar>
        <div v-if="banner" class="app-banner" role="alert">{{ banner }}</div>
        <div v-if="report?.note" class="app-note"><span
             class="lt-sm">Report of {{ report.made }}. </span>{{ report.note }}</div>
        <UnmetList v-if="report" />
        <div v-if="notices.length" class="app-banner" role="status">
          {{ notices[notices.length - 1] }}
        </div>
      </q-header>
      <q-drawer v-model="isDrawerOpen" show-if-above :width="190" :breakpoint="1023" bordered
                class="app-drawer">
        <q-list role="tablist" aria-label="Panels">
          <q-item v-for="one in panels" :key="one.name" clickable role="tab"
                  :aria-selected="one.name === panel" :active="one.name === panel"
                  :data-panel="one.name" @click="show(one.name)">
            <q-item-section avatar><q-icon :name="one.icon" /></q-item-section>
            <q-item-section>{{ one.label }}</q-item-section>
            <q-item-section v-if="one.name === 'faults' && activeFaults" side>
              <span class="faults-count" :title="faultsText + ' active'" data-active-faults
                >{{ activeFaults }}</span>
            </q-item-section>
            <q-item-section side class="gt-sm"><kbd>{{ one.key }}</kbd></q-item-section>
          </q-item>
        </q-list>
        <div v-if="hello?.ros" class="app-versions">launcher {{ hello.launcher }}<br>{{ hello.ros }}</div>
      </q-drawer>
      <q-page-container>
        <q-page class="app-page" :data-shown="panel">
          <component v-if="hello" :is="current.component" />
          <div v-else class="app-empty">Connecting…</div>
        </q-page>
      </q-page-container>
      <KeyList v-if="isHelpOpen !== null" v-model="isHelpOpen" :panels="panels" />
    </q-layout>`,
};
