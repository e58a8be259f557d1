// The panel graph: nodes and topics as a picture and as a list, live.

import { computed, nextTick, onUnmounted, reactive, ref, shallowRef, watch } from "vue";
import { request } from "page/feed.js";
import { graph, hello, traffic } from "page/store.js";
import { GraphChart } from "page/graph/chart.js";
import { GraphDetails } from "page/graph/details.js";
import { forcePositions } from "page/graph/force.js";
import { FrameTree } from "page/graph/frames.js";
import { namespaces, picture, places, repairs, sentence } from "page/graph/model.js";
import { isBetterTurned, turned } from "page/graph/turn.js";
import { ProbeProblem, isFrozen, isLive, trafficText, useSubscription } from "page/shared/ros.js";
import { hashValue, keepInHash } from "page/shared/address.js";
import { SearchField } from "page/shared/search_field.js";

const NONE = { nodes: {}, topics: {} };
const SHAPES = { node: "lens", topic: "crop_square", fold: "folder" };
// They outlive the panel.
const options = reactive({ internal: false, hidden: false, leaves: true, folded: new Set() });

// Rate and age of what passes an edge; of several publishers only the sum is known.
function edgeNoteOf(edge, item) {
  if (edge.state !== "running" || !item.endpoints) return "";
  const publishers = item.endpoints.filter((one) => one.direction === "publisher" && !one.ghost);
  const isTotal = edge.from === item.id || publishers.length === 1;
  return isTotal && publishers.length ? trafficText(traffic.value[item.name]) : "";
}

function noteOf(item) {
  if (item.kind !== "topic") return item.note;
  const parts = [];
  if (item.mismatches.length) parts.push("⚠");
  if (item.state !== "running") parts.push("gone");
  else parts.push(trafficText(traffic.value[item.name]));
  if (item.isLatched) parts.push("latched");
  return parts.filter(Boolean).join(" · ");
}

export default {
  components: { FrameTree, GraphDetails, ProbeProblem, SearchField },
  setup() {
    const area = ref(null);
    const search = ref("");
    const chosenId = ref(hashValue("item"));
    const local = shallowRef(NONE); // positions of the browser's own arrangement
    let chart = null;
    let echarts = null;
    let hasFitted = false;
    let isTurned = false; // decided whenever the picture is fitted
    let observer = null;
    useSubscription("topics");

    const isArrangedHere = computed(() => graph.value && !graph.value.positions);
    const drawing = computed(() => (graph.value ? picture(graph.value, options) : null));
    const spaces = computed(() => (graph.value ? namespaces(graph.value) : []));
    const mismatches = computed(() => graph.value?.mismatches ?? []);
    const chosenItem = computed(() => drawing.value?.byId.get(chosenId.value) ?? null);
    const matches = (item) => item.name.toLowerCase().includes(search.value.trim().toLowerCase());
    const listed = computed(() =>
      (drawing.value?.items ?? [])
        .filter(matches)
        .sort((a, b) =>
          a.kind === b.kind ? a.name.localeCompare(b.name) : a.kind === "topic" ? 1 : -1,
        ),
    );
    const isWaiting = computed(
      () =>
        graph.value?.positions &&
        !Object.keys(graph.value.positions.nodes).length &&
        graph.value.nodes.some((one) => !one.hidden),
    );

    function draw() {
      if (!chart || !drawing.value) return;
      if (isArrangedHere.value) local.value = forcePositions(echarts, graph.value, local.value);
      const { items } = drawing.value;
      const given = places(items, graph.value.positions ?? local.value);
      if (!hasFitted) isTurned = isBetterTurned(items, given, area.value);
      const at = isTurned ? turned(items, given) : given;
      chart.draw({
        ...drawing.value,
        places: at,
        isTurned,
        note: noteOf,
        edgeNote: edgeNoteOf,
        chosen: chosenId.value,
        isDim: (item) => search.value.trim() !== "" && !matches(item),
      });
      if (!hasFitted && at.size) fit();
    }
    let isSettling = true; // until somebody moves the picture, it is fitted as it is arranged
    let before = "";
    function arranged() {
      const corner = JSON.stringify(graph.value?.positions?.nodes ?? {});
      if (isSettling && before !== corner) hasFitted = false;
      before = corner;
    }
    const touched = () => (isSettling = false);
    const fit = () => {
      hasFitted = chart?.fit() ?? false;
    };
    const refit = () => {
      hasFitted = false;
      draw();
    };
    const choose = (id, { centre = false } = {}) => {
      chosenId.value = id;
      keepInHash({ item: id });
      if (centre && id) chart?.centre(id);
    };
    const chooseFromList = (id) => {
      touched();
      choose(id, { centre: true });
    };
    const firstMatch = () => listed.value.length && chooseFromList(listed.value[0].id);
    const fold = (name) => {
      if (options.folded.has(name)) options.folded.delete(name);
      else options.folded.add(name);
      if (chosenItem.value === null) choose(null);
    };
    async function arrange() {
      local.value = NONE;
      hasFitted = false;
      isSettling = true;
      if (!isArrangedHere.value && isLive.value) await request("arrange").catch(() => {});
      draw();
    }
    const zoom = (factor) => {
      touched();
      chart?.scale(factor);
    };
    const moveInList = (event, step) => {
      const rows = [...event.currentTarget.querySelectorAll("[role=option]")];
      const next = rows[rows.indexOf(document.activeElement) + step];
      next?.focus();
    };

    // The area comes with the first graph.
    watch(area, async (element) => {
      close();
      if (!element) return;
      ({ echarts } = await import("echarts"));
      if (area.value !== element) return;
      chart = new GraphChart(echarts, element, (id) => choose(id));
      element.addEventListener("wheel", touched, { passive: true });
      element.addEventListener("pointerdown", touched);
      observer = new ResizeObserver(() => {
        chart?.resize();
        if (isSettling) refit();
      });
      observer.observe(element);
      draw();
    });
    function close() {
      observer?.disconnect();
      chart?.dispose();
      chart = null;
    }
    onUnmounted(close);
    watch(graph, arranged, { flush: "pre" });
    watch([drawing, traffic, search, chosenId], draw, { flush: "post" });
    watch(
      () => window.Quasar.Dark.isActive,
      () => nextTick(draw),
    );
    const reason = computed(() => (hello.value?.graph.available ? "" : hello.value?.graph.reason));
    return {
      area,
      search,
      options,
      spaces,
      mismatches,
      chosenId,
      chosenItem,
      listed,
      isWaiting,
      graph,
      choose,
      chooseFromList,
      firstMatch,
      fold,
      refit,
      arrange,
      zoom,
      moveInList,
      noteOf,
      sentence,
      repairs,
      SHAPES,
      isFrozen,
      isLive,
      reason,
    };
  },
  template: `
    <div class="panel panel-tall graph-panel">
      <div class="panel-bar">
        <SearchField v-model="search" label="Search nodes and topics" placeholder="Search (/)"
                     @keydown.enter="firstMatch" />
        <span class="panel-group">
          <q-btn flat dense round icon="zoom_in" aria-label="Zoom in" title="Zoom in"
                 @click="zoom(1.3)" />
          <q-btn flat dense round icon="zoom_out" aria-label="Zoom out" title="Zoom out"
                 @click="zoom(1 / 1.3)" />
          <q-btn flat dense round icon="fit_screen" aria-label="Fit" title="Fit" data-action="fit"
                 @click="refit" />
          <q-btn v-if="!isFrozen" flat dense no-caps icon="auto_fix_high" label="Arrange"
                 data-action="arrange" @click="arrange" />
        </span>
        <q-toggle v-model="options.internal" dense label="/rosout, /parameter_events"
                  data-toggle="internal" />
        <q-toggle v-model="options.hidden" dense label="hidden" data-toggle="hidden" />
        <q-toggle v-model="options.leaves" dense label="topics with one side" data-toggle="leaves"
                  />
        <span class="spaces" v-if="spaces.length" role="group" aria-label="Namespaces">
          <button v-for="one in spaces" :key="one.name" type="button" class="chip"
                  :aria-pressed="options.folded.has(one.name)" :data-namespace="one.name"
                  @click="fold(one.name)">
            {{ options.folded.has(one.name) ? "▸" : "▾" }} {{ one.name }}
            <span class="muted">{{ one.count }}</span>
          </button>
        </span>
      </div>
      <div v-if="mismatches.length" class="graph-faults">
        <div v-for="one in mismatches" :key="sentence(one)" class="fault" role="alert"
             :data-mismatch="one.topic">
          <q-icon name="error" class="bad" aria-hidden="true" />
          <div>
            <button type="button" class="link fault-text" @click="chooseFromList('t ' + one.topic)">
              {{ sentence(one) }}
            </button>
            <div v-for="text in repairs(one)" :key="text" class="muted">{{ text }}</div>
          </div>
        </div>
      </div>
      <ProbeProblem />
      <div v-if="!graph" class="app-empty">
        {{ reason ? "There is no graph: " + reason : "Reading the graph…" }}
      </div>
      <div v-else class="graph-body card" :data-chosen="chosenItem ? '' : null">
        <div class="graph-list" role="listbox" aria-label="Nodes and topics"
             @keydown.down.prevent="moveInList($event, 1)"
             @keydown.up.prevent="moveInList($event, -1)"
             @keydown.esc="choose(null)">
          <div v-for="(item, index) in listed" :key="item.id" role="option" class="item graph-item"
               :tabindex="item.id === chosenId || (!chosenItem && index === 0) ? 0 : -1"
               :aria-selected="item.id === chosenId" :data-state="item.state"
               :data-node="item.kind === 'node' ? item.name : null"
               :data-topic="item.kind === 'topic' ? item.name : null"
               :data-fold="item.kind === 'fold' ? item.name : null"
               @click="chooseFromList(item.id)" @keydown.enter="chooseFromList(item.id)"
               @keydown.space.prevent="chooseFromList(item.id)">
            <q-icon :name="item.mismatches?.length ? 'error' : SHAPES[item.kind]" size="14px"
                    :class="item.mismatches?.length ? 'bad' : 'muted'" :aria-label="item.kind"
                    role="img" />
            <span class="item-text">
              <span class="item-name">{{ item.name }}</span>
              <span class="muted small" data-note>{{ noteOf(item) }}</span>
            </span>
          </div>
          <div v-if="!listed.length" class="muted small q-pa-sm">nothing matches</div>
        </div>
        <div class="graph-area">
          <div ref="area" class="graph-canvas" role="img"
               aria-label="Picture of the graph; the list beside it has the same"></div>
          <div v-if="isWaiting" class="graph-wait muted">Arranging…</div>
        </div>
        <FrameTree v-if="!chosenItem" />
        <GraphDetails v-if="chosenItem" :item="chosenItem" :key="chosenItem.id"
                      @close="choose(null)"
                      @choose="chooseFromList" @unfold="fold" @keydown.esc="choose(null)" />
      </div>
    </div>`,
};
