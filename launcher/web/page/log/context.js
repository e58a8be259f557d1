// The neighbours of a line: what all processes wrote around it, whatever the filters are.

import { computed, nextTick, ref, watch } from "vue";
import { log } from "page/store.js";
import { lowerBound } from "page/log/filter.js";
import { LogLine, timeText } from "page/log/line.js";

const AROUND = 50;

export const LogContext = {
  components: { LogLine },
  props: { row: { type: Object, required: true }, look: { type: Object, required: true } },
  emits: ["close", "pick"],
  setup(props) {
    const list = ref(null);
    const rows = computed(() => {
      void log.version.value;
      const at = lowerBound(log.rows, props.row.number);
      return log.rows.slice(Math.max(0, at - AROUND), at + AROUND + 1);
    });
    const reveal = async () => {
      await nextTick();
      list.value?.querySelector(".current")?.scrollIntoView({ block: "center" });
    };
    watch(() => props.row.number, reveal, { immediate: true });
    return { list, rows, time: computed(() => timeText(props.row, "clock")) };
  },
  template: `
    <section class="log-context" aria-label="Neighbours of a line" :data-context="row.number">
      <div class="log-context-head">
        <b>Around {{ time || "this line" }}</b>
        <span class="muted">{{ rows.length }} lines of all processes, without filters</span>
        <a :href="'#/timeline'" data-action="to-timeline"
           @click="$emit('pick', row)">in the timeline</a>
        <q-space />
        <q-btn flat round dense size="sm" icon="close" aria-label="Close (Escape)"
               @click="$emit('close')" />
      </div>
      <div class="log-context-lines" ref="list" tabindex="0">
        <LogLine v-for="one in rows" :key="one.number" :row="one" :times="look.times"
                 :with-colours="look.withColours" is-wrapped :is-short="look.isShort"
                 :is-current="one.number === row.number" />
      </div>
    </section>`,
};
