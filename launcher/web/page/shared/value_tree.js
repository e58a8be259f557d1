// A value as a tree that folds; strings of JSON are opened. Numbers may have a button to plot them.

import { computed, ref } from "vue";
import { childPath, isNumeric, opened } from "page/shared/paths.js";

const FIRST = 60; // members that are shown at once
const OPEN_DEPTH = 3;

export const ValueTree = {
  name: "ValueTree",
  props: {
    value: { default: null },
    name: { type: [String, Number], default: null },
    path: { type: String, default: "" }, // null where the grammar has no path
    depth: { type: Number, default: 0 },
    plots: { type: Boolean, default: false },
  },
  emits: ["plot"],
  setup(props) {
    const inner = computed(() => opened(props.value) ?? props.value);
    const isJson = computed(() => typeof props.value === "string" && inner.value !== props.value);
    const isBranch = computed(() => inner.value !== null && typeof inner.value === "object");
    const count = computed(() => (isBranch.value ? Object.keys(inner.value).length : 0));
    const isOpen = ref(props.depth < OPEN_DEPTH && count.value <= 40);
    const most = ref(FIRST);
    const members = computed(() => {
      const isArray = Array.isArray(inner.value);
      return Object.entries(inner.value)
        .slice(0, most.value)
        .map(([key, value]) => {
          const name = isArray ? Number(key) : key;
          return { key, value, path: childPath(props.path, name) };
        });
    });
    const summary = computed(() =>
      Array.isArray(inner.value) ? `[${count.value}]` : `{${count.value}}`,
    );
    const kind = computed(() => (inner.value === null ? "null" : typeof inner.value));
    const shown = computed(() =>
      typeof inner.value === "string" ? `"${inner.value}"` : String(inner.value),
    );
    const canPlot = computed(
      () => props.plots && props.path !== null && props.path !== "" && isNumeric(inner.value),
    );
    const more = () => (most.value += 500);
    return {
      inner,
      isJson,
      isBranch,
      isOpen,
      members,
      summary,
      shown,
      kind,
      count,
      most,
      more,
      canPlot,
    };
  },
  template: `
    <div class="tree" :class="{ 'tree-root': depth === 0 }">
      <div class="tree-row" v-if="depth > 0 || !isBranch">
        <button v-if="isBranch" type="button" class="tree-fold" :aria-expanded="isOpen"
                :aria-label="(isOpen ? 'Fold ' : 'Unfold ') + name" @click="isOpen = !isOpen">
          {{ isOpen ? "▾" : "▸" }}
        </button>
        <span v-else class="tree-fold"></span>
        <span v-if="name !== null" class="tree-name">{{ name }}</span>
        <span v-if="isBranch" class="muted">{{ summary }}</span>
        <span v-if="isJson && isBranch" class="tag">JSON in a string</span>
        <span v-if="!isBranch" class="tree-value" :data-kind="kind">{{ shown }}</span>
        <button v-if="canPlot" type="button" class="tree-plot" :data-plot="path"
                :aria-label="'Plot ' + path" @click="$emit('plot', path)">plot</button>
      </div>
      <div v-if="isBranch && (isOpen || depth === 0)" :class="{ 'tree-inner': depth > 0 }">
        <ValueTree v-for="one in members" :key="one.key" :name="one.key" :value="one.value"
                   :path="one.path" :depth="depth + 1" :plots="plots"
                   @plot="$emit('plot', $event)" />
        <button v-if="count > most" type="button" class="link" @click="more">
          {{ count - most }} more
        </button>
        <div v-if="!count" class="muted tree-empty">empty</div>
      </div>
    </div>`,
};
