// The panel plan: what the launch file says, and what became of it.

import { computed, nextTick, ref, watch } from "vue";
import { request } from "page/feed.js";
import { hello, link, plan, processes } from "page/store.js";
import { processCount } from "page/format.js";
import { link as address } from "page/shared/address.js";
import { argumentsOf, everyId, iconOf, nodesOf } from "page/plan/tree.js";
import { StateCell } from "page/processes/cells.js";
import { SearchField } from "page/shared/search_field.js";

const search = ref("");

// What else the launch file did: [title, texts].
function othersOf(document) {
  if (!document) return [];
  return [
    ["Texts that it logs", (document.logs ?? []).map((one) => one.message)],
    ["Requests to shut down", (document.shutdowns ?? []).map((one) => one.reason)],
    ["Lifecycle", (document.lifecycle ?? []).map((one) => `${one.node}: ${one.transition}`)],
  ].filter(([, texts]) => texts.length);
}

function useTree() {
  const tree = ref(null);
  const nodes = computed(() => nodesOf(plan.value));
  const expanded = ref([]);
  const ids = computed(() => everyId(nodes.value));
  let known = new Set();
  // All is open at first; what comes later as well.
  watch(
    ids,
    (now) => {
      expanded.value = now.filter((id) => !known.has(id) || expanded.value.includes(id));
      known = new Set(now);
    },
    { immediate: true },
  );
  // Folding all is undone by a search, so that what is found is seen.
  watch(search, () => nextTick(() => search.value && tree.value?.expandAll()));
  const matches = (node, text) =>
    text.toLowerCase().split(/\s+/).every((word) => node.words.includes(word));
  return { tree, nodes, expanded, matches, ids };
}

export default {
  components: { SearchField, StateCell },
  setup() {
    // Not before somebody looks: for the tree the launch file is evaluated once more.
    if (link.state === "open") request("tree").catch(() => {});
    const rows = computed(() => new Map(processes.value.map((row) => [row.name, row])));
    return {
      ...useTree(), plan, rows, search, iconOf, address, processCount,
      words: computed(() => argumentsOf(plan.value)),
      others: computed(() => othersOf(plan.value)),
      command: computed(() =>
        [hello.value?.run.target, ...(hello.value?.run.arguments ?? [])].join(" "),
      ),
      total: computed(() => (plan.value?.processes ?? []).length),
    };
  },
  template: `
    <div class="panel plan-panel">
      <div class="panel-bar">
        <SearchField v-model="search" label="Filter the plan" />
        <span v-if="plan" class="muted" data-count>{{ processCount(total) }} requested</span>
        <q-space />
        <q-btn flat dense no-caps label="Unfold all" data-action="unfold" @click="expanded = ids" />
        <q-btn flat dense no-caps label="Fold all" data-action="fold" @click="expanded = []" />
      </div>
      <div v-if="!plan" class="app-empty">The plan has not been read yet.</div>
      <template v-else>
        <div v-if="plan.error" class="plan-error" role="alert" data-plan-error>
          <q-icon name="error" class="bad" /> <b class="bad">{{ plan.error.type }}</b>
          <span dir="auto">{{ plan.error.message }}</span>
        </div>
        <div class="plan-target mono muted" dir="auto">{{ command }}</div>
        <section class="plan-box" aria-label="Launch file">
          <q-tree ref="tree" dense :nodes="nodes" node-key="id" label-key="text"
                  v-model:expanded="expanded" :filter="search"
                  :filter-method="matches" no-connectors
                  no-results-label="Nothing matches the filter."
                  no-nodes-label="The launch file has requested nothing yet.">
            <template #default-header="{ node }">
              <div class="plan-node" :data-kind="node.kind" :data-process="node.name">
                <q-icon :name="iconOf(node)"
                        :class="node.kind === 'skipped' ? 'muted' : 'plan-icon'"
                        :title="node.kind" />
                <a v-if="node.name" :href="address('log', { process: node.name })" class="plan-text"
                   data-action="to-log"
                   @click.stop><bdi dir="auto">{{ node.text }}</bdi></a>
                <bdi v-else class="plan-text" :class="{ muted: node.kind === 'skipped' }"
                     dir="auto">{{ node.text }}</bdi>
                <span v-if="node.kind === 'skipped'" class="tag">skipped</span>
                <StateCell v-if="rows.has(node.name)" :row="rows.get(node.name)" />
                <span v-else-if="node.kind === 'process'" class="tag"><q-icon
                     name="schedule" />not started</span>
                <bdi v-if="node.detail" class="muted plan-detail" dir="auto">{{ node.detail }}</bdi>
                <span v-if="node.place" class="mono muted plan-place">{{ node.place }}</span>
              </div>
            </template>
          </q-tree>
        </section>
        <section class="plan-box" aria-label="Arguments">
          <h2>Arguments</h2>
          <div v-if="plan.arguments_error" class="bad" dir="auto">{{ plan.arguments_error }}</div>
          <div v-if="!words.length" class="muted">The launch file declares none.</div>
          <dl v-else class="plan-arguments">
            <template v-for="one in words" :key="one.name">
              <dt :data-argument="one.name"><bdi dir="auto">{{ one.name }}</bdi></dt>
              <dd>
                <span class="mono"><bdi dir="auto">{{ one.value ?? "not declared" }}</bdi></span>
                <span v-if="one.isChanged" class="tag">default: <bdi
                     dir="auto">{{ one.default }}</bdi></span>
                <div class="muted" dir="auto">{{ one.description }}</div>
              </dd>
            </template>
          </dl>
        </section>
        <section v-for="[title, texts] in others" class="plan-box" :aria-label="title">
          <h2>{{ title }}</h2>
          <ul><li v-for="text in texts" dir="auto">{{ text }}</li></ul>
        </section>
      </template>
    </div>`,
};
