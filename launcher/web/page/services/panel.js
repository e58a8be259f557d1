// The panel services: a list, and a call by a form. The services that every node has are left out.

import { computed, ref, shallowRef } from "vue";
import { graph, hello } from "page/store.js";
import { clock, duration } from "page/format.js";
import { hashValue, keepInHash } from "page/shared/address.js";
import { isFrozen } from "page/shared/ros.js";
import { SearchField } from "page/shared/search_field.js";
import { ServiceCall } from "page/services/call.js";
import { ValueTree } from "page/shared/value_tree.js";

const NONE = "No node has services, besides those that every node has.";
const KEEP_CALLS = 50;
const calls = shallowRef([]); // newest first; outlive the panel

export default {
  components: { SearchField, ServiceCall, ValueTree },
  setup() {
    const filter = ref("");
    const chosen = ref(hashValue("service"));
    const open = ref(null); // the call of the history that is shown
    const services = computed(() =>
      (graph.value?.services ?? [])
        .filter((one) =>
          `${one.name} ${one.types.join(" ")}`
            .toLowerCase()
            .includes(filter.value.trim().toLowerCase()),
        )
        .sort((a, b) => a.name.localeCompare(b.name)),
    );
    const service = computed(
      () => (graph.value?.services ?? []).find((one) => one.name === chosen.value) ?? null,
    );
    const choose = (name) => {
      chosen.value = name;
      keepInHash({ service: name });
    };
    const called = (one) => (calls.value = [one, ...calls.value].slice(0, KEEP_CALLS));
    const move = (event, step) => {
      const all = [...event.currentTarget.querySelectorAll("[role=option]")];
      all[all.indexOf(document.activeElement) + step]?.focus();
    };
    const reason = computed(() => (hello.value?.graph.available ? "" : hello.value?.graph.reason));
    return {
      NONE,
      filter,
      chosen,
      open,
      services,
      service,
      choose,
      called,
      calls,
      move,
      graph,
      isFrozen,
      clock,
      duration,
      reason,
    };
  },
  template: `
    <div class="panel panel-tall">
      <div v-if="!graph" class="app-empty">
        {{ reason ? "There is no graph: " + reason : "Reading the graph…" }}
      </div>
      <div v-else class="split">
        <div class="split-list card">
          <SearchField v-model="filter" label="Filter services" />
          <div role="listbox" aria-label="Services" @keydown.down.prevent="move($event, 1)"
               @keydown.up.prevent="move($event, -1)">
            <div v-for="one in services" :key="one.name" role="option" tabindex="0"
                 class="item"
                 :data-service="one.name" :aria-selected="one.name === chosen"
                 @click="choose(one.name)"
                 @keydown.enter="choose(one.name)">
              <span class="item-text"><span class="item-name">{{ one.name }}</span>
                <span class="muted small wrap">{{ one.types.join(", ") }}</span></span>
            </div>
          </div>
          <div v-if="!services.length" class="muted small q-pa-sm">
            {{ graph.services.length ? "nothing matches" : NONE }}
          </div>
        </div>
        <div class="split-side-column">
          <section v-if="service" class="split-side card" :data-details="service.name"
                   aria-label="Service">
            <div class="details-head">
              <h2 class="details-title">{{ service.name }}</h2>
              <q-btn flat round dense icon="close" aria-label="Close" @click="choose(null)" />
            </div>
            <div class="mono muted small">{{ service.types.join(", ") }}</div>
            <ServiceCall v-if="!isFrozen" :key="service.name" :service="service.name"
                         :type="service.types[0]"
                         @called="called" />
          </section>
          <div v-else-if="chosen" class="split-side split-none muted">
            {{ chosen }} does not exist now.
          </div>
          <div v-else class="split-side split-none muted">Choose a service to call it.</div>
          <section v-if="calls.length" class="card calls" aria-label="Last calls">
            <h3>Last calls</h3>
            <div v-for="one in calls" :key="one.wall" class="call" :data-call="one.service">
              <button type="button" class="call-row" :aria-expanded="open === one"
                      @click="open = open === one ? null : one">
                <span class="muted mono">{{ clock(one.wall) }}</span>
                <q-icon :name="one.error ? 'error' : 'check'" :class="one.error ? 'bad' : 'good'"
                        role="img"
                        :aria-label="one.error ? 'failed' : 'answered'" />
                <span class="call-name">{{ one.service }}</span>
                <span class="muted">{{ duration(one.took_s) }}</span>
              </button>
              <div v-if="open === one" class="call-open">
                <pre class="mono small call-values">{{ one.values }}</pre>
                <div v-if="one.error" class="bad">{{ one.error.message }}</div>
                <ValueTree v-else :value="one.result" />
              </div>
            </div>
          </section>
        </div>
      </div>
    </div>`,
};
