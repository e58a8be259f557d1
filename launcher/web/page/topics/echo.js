// The last messages of a topic: as a tree, with pause and copy.

import { computed, ref, shallowRef, watch } from "vue";
import { messages } from "page/store.js";
import { bytes, clock } from "page/format.js";
import { copy, isFrozen, useSubscription } from "page/shared/ros.js";
import { opened, toYaml } from "page/shared/paths.js";
import { ValueTree } from "page/shared/value_tree.js";

const SHOWN = 60;

// Why a message comes without its data, or "".
function faultOf({ data, error, bytes: size }) {
  if (data !== null && data !== undefined) return "";
  if (error) return error;
  return size ? `${bytes(size).replace(".0 ", " ")}, too large to show` : "";
}

const brief = (message) => faultOf(message) || briefOf(message.data);

const briefOf = (data) => {
  const keys = Object.keys(data ?? {});
  const text = keys.length === 1 && keys[0] === "data" ? String(data.data) : JSON.stringify(data);
  return text.length > 160 ? `${text.slice(0, 160)}…` : text;
};

export const Echo = {
  components: { ValueTree },
  props: { topic: { type: String, required: true } },
  emits: ["plot"],
  setup(props) {
    const isPaused = ref(false);
    const kept = shallowRef([]); // what a pause shows
    const chosen = shallowRef(null);
    useSubscription("echo", () => ({ topic: props.topic }));
    const live = computed(() => messages.get(props.topic) ?? []);
    const rows = computed(() => (isPaused.value ? kept.value : live.value).slice(-SHOWN).reverse());
    const shown = computed(() => chosen.value ?? rows.value[0] ?? null);
    const skipped = computed(() => rows.value.reduce((sum, one) => sum + (one.skipped ?? 0), 0));
    const pause = (on) => {
      kept.value = live.value;
      isPaused.value = on;
      if (!on) chosen.value = null;
    };
    const choose = (one) => {
      if (!isPaused.value) pause(true);
      chosen.value = one;
    };
    const copied = ref("");
    const copyAs = async (kind) => {
      const data = shown.value.data;
      await copy(kind === "JSON" ? JSON.stringify(data, null, 2) : toYaml(data).trimStart());
      copied.value = `copied as ${kind}`;
      setTimeout(() => (copied.value = ""), 2000);
    };
    watch(
      () => props.topic,
      () => pause(false),
    );
    return {
      isPaused,
      pause,
      rows,
      shown,
      skipped,
      choose,
      chosen,
      copyAs,
      copied,
      clock,
      brief,
      fault: computed(() => (shown.value ? faultOf(shown.value) : "")),
      isFrozen,
      opened,
    };
  },
  template: `
    <div class="echo">
      <div class="row-buttons">
        <q-btn v-if="!isFrozen" flat dense no-caps :icon="isPaused ? 'play_arrow' : 'pause'"
               :label="isPaused ? 'Continue' : 'Pause'" data-action="pause"
               @click="pause(!isPaused)" />
        <q-btn flat dense no-caps icon="content_copy" label="YAML" :disable="!shown || fault !== ''"
               aria-label="Copy as YAML"
               @click="copyAs('YAML')" />
        <q-btn flat dense no-caps icon="content_copy" label="JSON" :disable="!shown || fault !== ''"
               aria-label="Copy as JSON"
               @click="copyAs('JSON')" />
        <span class="muted small" role="status">{{ copied }}</span>
        <span v-if="skipped" class="muted small" data-field="skipped">
          {{ skipped }} messages in between not shown
        </span>
      </div>
      <template v-if="shown">
        <div class="muted small mono" data-field="time">{{ clock(shown.wall, true) }}</div>
        <div v-if="fault" class="warn" role="status" data-field="fault">{{ fault }}</div>
        <ValueTree v-else :value="shown.data" plots data-field="message" @plot="$emit('plot', $event)" />
        <h3>Last messages</h3>
        <div class="echo-list" role="listbox" aria-label="Last messages">
          <button v-for="(one, index) in rows" :key="one.wall + '-' + index" type="button"
                  class="echo-row mono"
                  role="option" :aria-selected="one === chosen" @click="choose(one)">
            <span class="muted">{{ clock(one.wall, true) }}</span>
            <span v-if="one.skipped" class="tag">+{{ one.skipped }}</span>
            <span class="echo-text">{{ brief(one) }}</span>
          </button>
        </div>
      </template>
      <div v-else class="muted">{{ isFrozen ? "No message was kept." : "Waiting for a message…"
        }}</div>
    </div>`,
};
