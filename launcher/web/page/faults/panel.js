// The panel faults: what is wrong in a watched run, and why.

import { computed, ref } from "vue";
import { faults, hello } from "page/store.js";
import { clock, duration } from "page/format.js";
import { FaultDetails } from "page/faults/details.js";
import { arranged, stateOf } from "page/faults/order.js";
import { hashValue, keepInHash } from "page/shared/address.js";
import { useNarrow } from "page/shared/ros.js";
import { SearchField } from "page/shared/search_field.js";

const COUNTED = ["active", "suspected", "healed"];

export default {
  components: { FaultDetails, SearchField },
  setup() {
    const filter = ref("");
    const chosen = ref(hashValue("fault"));
    const isNarrow = useNarrow(900);
    const isMedium = useNarrow(1400);
    const rows = computed(() => {
      const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
      return arranged([...(faults.value?.values() ?? [])]).filter(({ fault }) => {
        const { word } = stateOf(fault);
        const all = [fault.fault, fault.seen, fault.cause, word, ...fault.processes, ...fault.topics];
        const text = all.join(" ").toLowerCase();
        return words.every((one) => text.includes(one));
      });
    });
    const count = computed(() => {
      const all = [...(faults.value?.values() ?? [])];
      const number = (state) => all.filter((one) => one.state === state).length;
      const texts = COUNTED.map((state) => [number(state), state]).filter(([found]) => found);
      return texts.map((one) => one.join(" ")).join(", ") || "no fault";
    });
    const fault = computed(() => faults.value?.get(chosen.value) ?? null);
    const choose = (name) => {
      chosen.value = name;
      keepInHash({ fault: name });
    };
    const move = (event, step) => {
      const all = [...event.currentTarget.closest("tbody").querySelectorAll("tr[data-fault]")];
      all[all.indexOf(event.currentTarget) + step]?.focus();
    };
    const sinceOf = (one) => {
      const lasted = (one.healed_s ?? null) === null ? "" : ` for ${duration(one.healed_s - one.first_s)}`;
      return clock(one.first_s) + lasted;
    };
    return {
      filter, chosen, isNarrow, isMedium, rows, count, fault, choose, move, sinceOf, stateOf,
      faults, hello,
    };
  },
  template: `
    <div class="panel panel-tall faults-panel">
      <div v-if="!faults" class="app-empty" data-unwatched>
        {{ hello.frozen ? "This run was not watched."
           : "This run is not watched: start it with --watchful, or with --expect FILE." }}
      </div>
      <template v-else>
        <div class="panel-bar">
          <SearchField v-model="filter" label="Filter the faults" />
          <span class="muted" data-count>{{ count }}</span>
        </div>
        <div v-if="!faults.size" class="app-empty">All expectations hold.</div>
        <div v-else class="split">
          <q-markup-table dense flat bordered class="split-table faults-table" aria-label="Faults">
            <thead><tr>
              <th class="text-left">State</th><th class="text-left">Fault</th>
              <template v-if="!isNarrow">
                <th class="text-left">Since</th><th class="text-left">Seen</th>
                <th v-if="!isMedium" class="text-left">Cause</th>
              </template>
            </tr></thead>
            <tbody>
              <tr v-for="{ depth, fault: one } in rows" :key="one.fault" :data-fault="one.fault"
                  :data-state="stateOf(one).word" tabindex="0" class="cursor-pointer"
                  :aria-selected="one.fault === chosen" :class="{ chosen: one.fault === chosen }"
                  @click="choose(one.fault)" @keydown.enter="choose(one.fault)"
                  @keydown.down.prevent="move($event, 1)" @keydown.up.prevent="move($event, -1)">
                <td class="faults-word" :class="stateOf(one).tone">
                  <q-icon :name="stateOf(one).icon" aria-hidden="true" />{{ stateOf(one).word
                  }}<span v-if="one.count > 1" class="muted" :title="one.count + ' times'">
                  ×{{ one.count }}</span>
                </td>
                <td class="wrap faults-name" :style="{ paddingLeft: 8 + 18 * Math.min(depth, 6) + 'px !important' }">
                  <span v-if="depth" class="muted" aria-label="follows">↳ </span
                  ><bdi dir="auto">{{ one.fault }}</bdi>
                  <template v-if="isNarrow">
                    <div class="small" dir="auto">{{ one.seen }}</div>
                    <div class="small muted" dir="auto">{{ sinceOf(one) }}{{
                      one.cause ? ": " + one.cause : "" }}</div>
                  </template>
                </td>
                <template v-if="!isNarrow">
                  <td class="mono">{{ sinceOf(one) }}</td>
                  <td class="wrap" dir="auto">{{ one.seen }}
                    <div v-if="isMedium && one.cause" class="small muted" dir="auto">{{ one.cause }}</div>
                  </td>
                  <td v-if="!isMedium" class="wrap" dir="auto">{{ one.cause }}</td>
                </template>
              </tr>
            </tbody>
          </q-markup-table>
          <section v-if="fault" class="split-side card" :data-details="fault.fault"
                   aria-label="Fault">
            <div class="details-head">
              <h2 class="details-title"><bdi dir="auto">{{ fault.fault }}</bdi></h2>
              <q-btn flat round dense icon="close" aria-label="Close" @click="choose(null)" />
            </div>
            <FaultDetails :fault="fault" @choose="choose" />
          </section>
          <div v-else class="split-side split-none muted">Choose a fault to see its evidence.</div>
        </div>
        <div v-if="faults.size && !rows.length" class="app-empty">No fault matches the filter.</div>
      </template>
    </div>`,
};
