// The panel topics: a table, the messages of one, publishing, and plots of numbers.

import { computed, ref, watch } from "vue";
import { graph, hello, plots, traffic } from "page/store.js";
import { bytes, duration, rate } from "page/format.js";
import { INTERNAL, isLatching } from "page/graph/model.js";
import { Echo } from "page/topics/echo.js";
import { hashValue, hashValues, keepInHash } from "page/shared/address.js";
import { Plot } from "page/topics/plot.js";
import { Publish } from "page/topics/publish.js";
import { SearchField } from "page/shared/search_field.js";
import { ProbeProblem, isFrozen, isReadOnly, useNarrow, useSubscription } from "page/shared/ros.js";

const number = (name, label, format) => ({
  name,
  label,
  field: name,
  sortable: true,
  align: "right",
  format: (value) => format(value),
  sort: (a, b) => (a ?? -1) - (b ?? -1),
});
const COLUMNS = [
  { name: "name", label: "Topic", field: "name", sortable: true, align: "left" },
  { name: "type", label: "Type", field: "type", sortable: true, align: "left" },
  number("rate_hz", "Hz", rate),
  number("bytes_per_s", "Bytes/s", bytes),
  number("publishers", "Pub", (value) => value),
  number("subscriptions", "Sub", (value) => value),
  number("age_s", "Age", duration),
];
const CLASSES = { name: "wrap", type: "type muted small" };
const NARROW = new Set(["name", "rate_hz", "age_s"]);
const MEDIUM = new Set(COLUMNS.map((one) => one.name).filter((name) => name !== "type"));

const MANY = 100; // from here on only the rows in view are drawn

const fromHash = () =>
  hashValues("plot")
    .map((one) => one.replace(/:([^:]*)$/, "\n$1"))
    .filter((one) => one.includes("\n"));

export default {
  components: { Echo, Plot, ProbeProblem, Publish, SearchField },
  setup() {
    useSubscription("topics");
    const filter = ref("");
    const showsInternal = ref(false);
    const chosen = ref(hashValue("topic"));
    const tab = ref("echo");
    const start = fromHash();
    const series = ref(start.length || !isFrozen.value ? start : [...plots.keys()]);
    const isNarrow = useNarrow(900);
    const isMedium = useNarrow(1700);
    const latched = computed(
      () => new Set((graph.value?.endpoints ?? []).filter(isLatching).map((one) => one.topic)),
    );
    const faulty = computed(() => new Set((graph.value?.mismatches ?? []).map((one) => one.topic)));
    const rows = computed(() =>
      (graph.value?.topics ?? [])
        .filter((one) => showsInternal.value || !(INTERNAL.has(one.name) || /\/_/.test(one.name)))
        .map((one) => ({ ...traffic.value[one.name], ...one, type: one.types.join(", ") }))
        .filter((one) =>
          `${one.name} ${one.type}`.toLowerCase().includes(filter.value.trim().toLowerCase()),
        ),
    );
    const row = computed(() => {
      const one = (graph.value?.topics ?? []).find((topic) => topic.name === chosen.value);
      return one ? { ...one, type: one.types[0] ?? "" } : null;
    });
    const columns = computed(() => {
      if (!isMedium.value) return COLUMNS;
      return COLUMNS.filter((one) => (isNarrow.value ? NARROW : MEDIUM).has(one.name));
    });
    const choose = (name) => {
      chosen.value = name;
      keepInHash({ topic: name });
    };
    const keepPlots = () => keepInHash({ plot: series.value.map((key) => key.replace("\n", ":")) });
    const plot = (field) => {
      const key = `${chosen.value}\n${field}`;
      if (!series.value.includes(key)) series.value = [...series.value, key];
      keepPlots();
    };
    const unplot = (key) => {
      series.value = series.value.filter((one) => one !== key);
      keepPlots();
    };
    const move = (event, step) => {
      const all = [...event.currentTarget.closest("tbody").querySelectorAll("tr[data-topic]")];
      all[all.indexOf(event.currentTarget) + step]?.focus();
    };
    watch(isReadOnly, () => (tab.value = "echo"));
    const reason = computed(() => (hello.value?.graph.available ? "" : hello.value?.graph.reason));
    return {
      CLASSES,
      MANY,
      filter,
      showsInternal,
      chosen,
      tab,
      series,
      rows,
      row,
      columns,
      choose,
      plot,
      unplot,
      move,
      latched,
      faulty,
      graph,
      isReadOnly,
      isMedium,
      reason,
    };
  },
  template: `
    <div class="panel panel-tall topics-panel" :data-chosen="row ? '' : null">
      <div class="panel-bar">
        <SearchField v-model="filter" label="Filter topics" />
        <span class="muted">{{ rows.length === 1 ? "1 topic" : rows.length + " topics" }}</span>
        <q-toggle v-model="showsInternal" dense label="/rosout and hidden" data-toggle="internal" />
      </div>
      <ProbeProblem />
      <div v-if="!graph" class="app-empty">
        {{ reason ? "There is no graph: " + reason : "Reading the graph…" }}
      </div>
      <div v-else class="split">
        <q-table class="split-table" flat bordered dense :rows="rows" :columns="columns"
                 row-key="name" binary-state-sort
                 :pagination="{ rowsPerPage: 0, sortBy: 'name' }" hide-pagination
                 :virtual-scroll="rows.length > MANY" :virtual-scroll-item-size="36"
                 no-data-label="no topics">
          <template #body="props">
            <q-tr :props="props" :data-topic="props.row.name" tabindex="0" class="cursor-pointer"
                  :aria-selected="props.row.name === chosen"
                  :class="{ chosen: props.row.name === chosen }"
                  @click="choose(props.row.name)" @keydown.enter="choose(props.row.name)"
                  @keydown.down.prevent="move($event, 1)" @keydown.up.prevent="move($event, -1)">
              <q-td v-for="col in props.cols" :key="col.name" :props="props" :data-column="col.name"
                    :class="CLASSES[col.name] ?? 'mono'">
                <template v-if="col.name === 'name'">
                  <q-icon v-if="faulty.has(props.row.name)" name="error" class="bad" role="img"
                          aria-label="nothing arrives at a subscription" />
                  <bdi>{{ col.value }}</bdi>
                  <span v-if="latched.has(props.row.name)" class="tag" data-latched>latched</span>
                  <div v-if="isMedium" class="muted small">{{ props.row.type }}</div>
                </template>
                <template v-else-if="col.name === 'rate_hz' && props.row.state === 'failed'">
                  <span class="bad" :title="props.row.error">not measured</span>
                </template>
                <template v-else>{{ col.value }}</template>
              </q-td>
            </q-tr>
          </template>
        </q-table>
        <section v-if="row" class="split-side card" :data-details="row.name" aria-label="Topic">
          <div class="details-head">
            <h2 class="details-title">{{ row.name }}</h2>
            <q-btn flat round dense icon="close" aria-label="Close" @click="choose(null)" />
          </div>
          <div class="mono muted small">{{ row.type }}</div>
          <q-tabs v-if="!isReadOnly" v-model="tab" dense no-caps align="left" inline-label
                  :breakpoint="0" indicator-color="primary" class="q-mb-sm">
            <q-tab name="echo" label="Messages" /><q-tab name="publish" label="Publish" />
          </q-tabs>
          <Echo v-if="tab === 'echo'" :topic="row.name" @plot="plot" />
          <Publish v-else :topic="row.name" :type="row.type" :subscriptions="row.subscriptions"
                   :key="row.name" />
        </section>
        <div v-else class="split-side split-none muted">Choose a topic to see its messages.</div>
      </div>
      <Plot v-if="series.length" :series="series" @remove="unplot" />
    </div>`,
};
