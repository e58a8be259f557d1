// One line of the log: time, process, level, text with its colours.

import { computed } from "vue";
import { hello } from "page/store.js";
import { clock } from "page/format.js";
import { SKIPPED, nameOf } from "page/log/filter.js";
import { withoutPrefix } from "page/shared/prefix.js";
import { pieces } from "page/shared/sgr.js";

const LONG = 2000; // characters that are drawn of a line that is not wrapped
const MARKS = { DEBUG: "D", INFO: "", WARN: "▲ W", ERROR: "■ E", FATAL: "■ F" };
const coloured = new WeakMap(); // row -> pieces with colours

function piecesOf(row, text, withColours, isWhole) {
  const isLong = !isWhole && text.length > LONG;
  if (isLong) {
    const more = text.length - LONG;
    const cut = pieces(text.slice(0, LONG), withColours);
    const note = ` … ${more.toLocaleString("en")} more characters; wrap lines to see them`;
    return [...cut, ["muted", note]];
  }
  if (!withColours || text !== row.text) return pieces(text, withColours);
  let found = coloured.get(row);
  if (!found) coloured.set(row, (found = pieces(row.text)));
  return found;
}

// `times`: "clock", "since" (since the start of the run) or "none".
export function timeText(row, times) {
  if (times === "none" || row.time === null || row.time === undefined) return "";
  if (times === "clock") return clock(row.time, true);
  return `${(row.time - (hello.value?.run.started_wall_s ?? 0)).toFixed(3)} s`;
}

export const LogLine = {
  props: {
    row: { type: Object, required: true },
    times: { type: String, default: "clock" },
    withColours: { type: Boolean, default: true },
    isWrapped: { type: Boolean, default: false },
    isShort: { type: Boolean, default: false },
    isCurrent: { type: Boolean, default: false },
  },
  setup(props) {
    return {
      isSkipped: computed(() => props.row.stream === SKIPPED),
      time: computed(() => timeText(props.row, props.times)),
      name: computed(() => nameOf(props.row)),
      mark: computed(() => MARKS[props.row.level] ?? ""),
      parts: computed(() => {
        const { row, withColours, isWrapped } = props;
        const text = props.isShort ? withoutPrefix(row.text, row.process) : row.text;
        return piecesOf(row, text, withColours, isWrapped);
      }),
    };
  },
  template: `
    <div v-if="isSkipped" class="line line-skipped" :data-line="row.number" data-skipped
         role="separator"
         :class="{ current: isCurrent }"><span dir="auto">{{ row.text }}</span></div>
    <div v-else class="line" :data-line="row.number" :data-level="row.level" :data-of="name"
         :class="{ current: isCurrent, wrapped: isWrapped }" :aria-current="isCurrent || null">
      <span v-if="times !== 'none'" class="line-time">{{ time }}</span>
      <span class="line-process" :title="name"><bdi dir="auto">{{ name }}</bdi></span>
      <span class="line-mark" :title="row.level">{{ mark }}</span>
      <bdi class="line-text" dir="auto"><span v-for="[kind, text] in parts"
           :class="kind">{{ text }}</span></bdi>
    </div>`,
};
