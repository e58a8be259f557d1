// Pieces of a row that the table and the cards of the processes share.

import { computed } from "vue";
import { history, link as connection } from "page/store.js";
import { clock } from "page/format.js";
import { ACTIONS, errorOf, marksOf, stateOf } from "page/processes/rows.js";
import { Sparkline } from "page/processes/sparkline.js";
import { isConnected, isSteerable } from "page/processes/steering.js";
import { link } from "page/shared/address.js";
import { withoutPrefix } from "page/shared/prefix.js";
import { plain } from "page/shared/sgr.js";

const LEAST = { cpu: 10, memory: 1e6, lines: 5 };

export const StateCell = {
  props: { row: { type: Object, required: true } },
  setup(props) {
    const state = computed(() => {
      const found = stateOf(props.row);
      const isPast = connection.state === "frozen" && props.row.pid !== null;
      return isPast ? { ...found, word: `was ${found.word}` } : found;
    });
    const marks = computed(() => marksOf(props.row));
    const seen = computed(() => JSON.stringify([state.value, marks.value]));
    return { state, marks, seen };
  },
  template: `
    <span v-memo="[seen]" class="process-states">
    <span class="process-state" :class="state.tone" :data-state="row.state">
      <q-icon :name="state.icon" aria-hidden="true" />
      <span class="process-word" dir="auto" :title="state.word">{{ state.word }}</span>
    </span>
    <span v-for="[icon, text] in marks" class="tag" :title="text" :data-mark="text">
      <q-icon :name="icon" aria-hidden="true" /><span dir="auto">{{ text }}</span>
    </span>
    </span>`,
};

export const SparkCell = {
  components: { Sparkline },
  props: { row: { type: Object, required: true }, what: { type: String, required: true } },
  setup(props) {
    return {
      values: computed(() => history.get(props.row.name)?.[props.what] ?? []),
      least: computed(() => LEAST[props.what]),
      label: computed(() => `${props.what} of ${props.row.name} over the last minutes`),
    };
  },
  template: `<Sparkline :values="values" :least="least" :label="label" />`,
};

export const ErrorCell = {
  props: { row: { type: Object, required: true } },
  setup(props) {
    const error = computed(() => errorOf(props.row));
    return {
      error,
      clock,
      text: computed(() => withoutPrefix(plain(error.value.text), props.row.name).slice(0, 300)),
      href: computed(() =>
        link("log", { process: props.row.name, number: error.value.number }),
      ),
    };
  },
  template: `
    <a v-if="error" class="process-error" :href="href" :title="text" data-action="last-error"
       @dblclick.stop>
      <span class="mono">{{ clock(error.time) }}</span> <bdi dir="auto">{{ text }}</bdi>
    </a>`,
};

// `fits`: the names of the verbs that make sense, in one text. It stays the same from second to
// second, so that the many buttons are not drawn anew with the numbers.
export const ActionButtons = {
  props: { fits: { type: String, required: true }, label: { type: String, required: true } },
  emits: ["act"],
  setup(props) {
    const able = computed(() => new Set(props.fits.split(" ")));
    const can = (name) => isConnected.value && able.value.has(name);
    const title = (action) => (action.key ? `${action.name} (${action.key})` : action.name);
    // Of a pair, the one that makes sense; both for a selection that needs both.
    const shown = computed(() => {
      const has = (name) => able.value.has(name);
      const isHidden = {
        mute: !has("mute") && has("unmute"),
        unmute: !has("unmute"),
        pause: has("resume") && !has("pause"),
        resume: !has("resume"),
      };
      return ACTIONS.filter((one) => !isHidden[one.name]);
    });
    return { can, title, shown, isSteerable };
  },
  template: `
    <span v-if="isSteerable" class="process-actions" role="group"
          :aria-label="'Actions for ' + label">
      <button v-for="action in shown" :key="action.name" type="button" class="action"
              :disabled="!can(action.name)" :data-action="action.name"
              :aria-label="action.name + ' ' + label" :title="title(action)"
              @click.stop="$emit('act', action.name)" @dblclick.stop>
        <q-icon :name="action.icon" />
      </button>
    </span>`,
};
