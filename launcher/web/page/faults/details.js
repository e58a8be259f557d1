// All that is known of a fault: what was expected, the evidence, and what users decide.

import { computed, ref, watch } from "vue";
import { run } from "page/feed.js";
import { chosen } from "page/store.js";
import { clock, day, duration } from "page/format.js";
import { stateOf } from "page/faults/order.js";
import { isConnected, isSteerable } from "page/processes/steering.js";
import { link } from "page/shared/address.js";
import { Problem } from "page/shared/requests.js";
import { plain } from "page/shared/sgr.js";
import { ValueTree } from "page/shared/value_tree.js";

const FOR = [
  { label: "for 10 min", value: 600 },
  { label: "for an hour", value: 3600 },
  { label: "for good", value: null },
];

const moment = (wall) => (wall === null || wall === undefined ? "" : clock(wall, true));

function mutedText({ reason, until_s: until }) {
  const end = until === null ? "for good" : `until ${day(until)} ${clock(until)}`;
  return [end, reason].filter(Boolean).join(": ");
}

// [name, text] of what is not a link.
function factsOf(fault) {
  const value = fault.value === null ? "" : `${fault.value} ${fault.unit}`.trim();
  const since = fault.confirmed_s === null ? "" : fault.confirmed_s - fault.first_s;
  return [
    ["expected", fault.expected],
    ["seen", fault.seen],
    ["measured", value],
    ["first seen", moment(fault.first_s)],
    ["confirmed", since === "" ? "" : `${moment(fault.confirmed_s)}, after ${duration(since)}`],
    ["last seen", moment(fault.last_s)],
    ["healed", moment(fault.healed_s)],
    ["confirmed in this run", fault.count > 1 ? `${fault.count} times` : ""],
    ["rule", fault.rule],
    ["incident", fault.incident],
    ["kind", fault.kind],
    ["written in", fault.place ?? "part of every watched run"],
    ["acknowledged", fault.acknowledged && (fault.acknowledged.reason || "yes")],
    ["muted", fault.muted && mutedText(fault.muted)],
    ["nodes", fault.nodes.join(", ")],
  ].filter(([, text]) => text !== null && text !== undefined && text !== "");
}

export const FaultDetails = {
  components: { Problem, ValueTree },
  props: { fault: { type: Object, required: true } },
  emits: ["choose"],
  setup(props) {
    const reason = ref("");
    const forHow = ref(FOR[0].value);
    const problem = ref(null);
    const isBusy = ref(false);
    watch(
      () => props.fault.fault,
      () => {
        reason.value = "";
        problem.value = null;
      },
    );
    const change = async (what) => {
      const options = { [what]: props.fault.fault };
      if (what !== "unmute" && reason.value) options.reason = reason.value;
      if (what === "mute" && forHow.value !== null) options.for_s = forHow.value;
      isBusy.value = true;
      problem.value = null;
      try {
        await run("faults", [], options);
        reason.value = "";
      } catch (error) {
        problem.value = { message: error.message, hint: error.hint };
      } finally {
        isBusy.value = false;
      }
    };
    return {
      FOR, reason, forHow, problem, isBusy, change, isSteerable, isConnected, link,
      facts: computed(() => factsOf(props.fault)),
      state: computed(() => stateOf(props.fault)),
      lines: computed(() => props.fault.lines.map(plain).join("\n")),
      logLink: computed(() => link("log", { at: props.fault.first_s.toFixed(3) })),
      markMoment: () => (chosen.moment = props.fault.first_s),
    };
  },
  template: `
    <div class="faults-details">
      <div class="faults-state" :class="state.tone">
        <q-icon :name="state.icon" aria-hidden="true" /> {{ state.word }}
      </div>
      <p v-if="fault.cause" class="faults-cause" dir="auto" data-field="cause">{{ fault.cause }}</p>
      <p v-if="fault.follows" class="faults-cause">follows from
        <button type="button" class="link" data-action="to-root"
                @click="$emit('choose', fault.follows)">{{ fault.follows }}</button></p>
      <div class="faults-links">
        <a href="#/timeline" data-action="to-timeline" @click="markMoment">in the timeline</a>
        <a :href="logLink" data-action="to-log">in the log</a>
        <a v-for="name in fault.processes" :key="name" :href="link('log', { process: name })"
           dir="auto">log of {{ name }}</a>
        <a v-for="name in fault.topics" :key="name" :href="link('topics', { topic: name })"
           dir="auto">{{ name }}</a>
      </div>
      <dl class="facts">
        <template v-for="[name, text] in facts" :key="name">
          <dt>{{ name }}</dt><dd dir="auto" :data-field="name">{{ text }}</dd>
        </template>
      </dl>
      <template v-if="lines">
        <h3>Last lines</h3>
        <pre class="code-block" data-field="lines">{{ lines }}</pre>
      </template>
      <template v-if="fault.message !== null">
        <h3>Last message</h3>
        <ValueTree :value="fault.message" />
      </template>
      <form v-if="isSteerable && fault.state !== 'healed'" class="faults-form"
            @submit.prevent="change('acknowledge')">
        <h3>Decide</h3>
        <q-input v-model="reason" dense outlined placeholder="Reason" aria-label="Reason" />
        <div class="row-buttons">
          <q-btn outline dense no-caps icon="person" label="Acknowledge" type="submit"
                 :disable="!isConnected || isBusy" data-action="acknowledge"
                 title="Somebody takes care of it; it stays active" />
          <template v-if="!fault.muted">
            <q-btn outline dense no-caps icon="notifications_off" label="Mute"
                   :disable="!isConnected || isBusy" data-action="mute"
                   title="No lines, marks or actions" @click="change('mute')" />
            <select v-model="forHow" class="faults-for" aria-label="How long it is muted">
              <option v-for="one in FOR" :key="one.label" :value="one.value">{{ one.label }}</option>
            </select>
          </template>
          <q-btn v-else outline dense no-caps icon="notifications" label="Unmute"
                 :disable="!isConnected || isBusy" data-action="unmute" @click="change('unmute')" />
        </div>
        <Problem :error="problem" />
      </form>
    </div>`,
};
