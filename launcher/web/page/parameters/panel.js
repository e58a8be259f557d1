// The panel parameters: those of one node, to read and to change.

import { computed, ref, watch } from "vue";
import { graph, hello } from "page/store.js";
import { hashValue, keepInHash } from "page/shared/address.js";
import { Parameter } from "page/parameters/parameter.js";
import { Problem, useProbe } from "page/shared/requests.js";
import { SearchField } from "page/shared/search_field.js";
import { isFrozen, isLive } from "page/shared/ros.js";

export default {
  components: { Parameter, Problem, SearchField },
  setup() {
    const nodeFilter = ref("");
    const filter = ref("");
    const chosen = ref(hashValue("node"));
    const asking = useProbe();
    const has = (text, part) => text.toLowerCase().includes(part.trim().toLowerCase());
    const nodes = computed(() =>
      (graph.value?.nodes ?? []).filter(
        (one) => one.state === "running" && !one.hidden && has(one.name, nodeFilter.value),
      ),
    );
    const parameters = computed(() =>
      (asking.result?.parameters ?? []).filter((one) =>
        has(`${one.name} ${one.description}`, filter.value),
      ),
    );
    const refresh = () =>
      chosen.value && isLive.value && asking.ask("describe_parameters", { node: chosen.value });
    const choose = (name) => {
      chosen.value = name;
      keepInHash({ node: name });
    };
    watch(
      chosen,
      () => {
        asking.clear();
        filter.value = "";
        refresh();
      },
      { immediate: true },
    );
    watch(isLive, (now) => now && refresh());
    const isGone = computed(
      () =>
        chosen.value &&
        graph.value &&
        !graph.value.nodes.some((one) => one.name === chosen.value && one.state === "running"),
    );
    const move = (event, step) => {
      const all = [...event.currentTarget.querySelectorAll("[role=option]")];
      all[all.indexOf(document.activeElement) + step]?.focus();
    };
    const reason = computed(() => (hello.value?.graph.available ? "" : hello.value?.graph.reason));
    return {
      nodeFilter,
      filter,
      chosen,
      asking,
      nodes,
      parameters,
      refresh,
      choose,
      isGone,
      isFrozen,
      isLive,
      graph,
      move,
      reason,
    };
  },
  template: `
    <div class="panel panel-tall">
      <div v-if="isFrozen" class="app-empty">
        A report has no parameters: only a run can be asked for them.
      </div>
      <div v-else-if="!graph" class="app-empty">
        {{ reason ? "There is no graph: " + reason : "Reading the graph…" }}
      </div>
      <div v-else class="split">
        <div class="split-list card">
          <SearchField v-model="nodeFilter" label="Filter nodes" />
          <div role="listbox" aria-label="Nodes" @keydown.down.prevent="move($event, 1)"
               @keydown.up.prevent="move($event, -1)">
            <div v-for="one in nodes" :key="one.name" role="option" tabindex="0" class="item"
                 :data-node="one.name"
                 :aria-selected="one.name === chosen" @click="choose(one.name)"
                 @keydown.enter="choose(one.name)">
              <span class="item-name">{{ one.name }}</span>
            </div>
          </div>
          <div v-if="!nodes.length" class="muted small q-pa-sm">no nodes</div>
        </div>
        <section v-if="chosen" class="split-side card" :data-details="chosen"
                 aria-label="Parameters">
          <div class="details-head">
            <h2 class="details-title">{{ chosen }}</h2>
            <SearchField v-model="filter" label="Filter parameters" placeholder="Filter" />
            <q-btn flat round dense icon="refresh" aria-label="Refresh" data-action="refresh"
                   :loading="asking.busy"
                   :disable="!isLive" @click="refresh" />
          </div>
          <div v-if="isGone" class="warn small" role="status">▲ This node is not running.</div>
          <Problem :error="asking.error" />
          <Parameter v-for="one in parameters" :key="chosen + ' ' + one.name" :node="chosen"
                     :parameter="one"
                     @set="refresh" />
          <div v-if="asking.result && !parameters.length" class="muted">no parameters</div>
          <div v-if="!asking.result && asking.busy" class="muted">Asking the node…</div>
        </section>
        <div v-else class="split-side split-none muted">Choose a node to see its parameters.</div>
      </div>
    </div>`,
};
