// A small line of the last values; gaps where a value is null.

import { computed } from "vue";

const WIDTH = 56;
const HEIGHT = 18;

// Paths of the line and of the area below it; `top` is the value at the upper edge.
function pathsOf(values, top, most) {
  const step = WIDTH / Math.max(1, most - 1);
  const scale = (HEIGHT - 2) / top;
  let [line, area, x, isOpen] = ["", "", 0, false];
  const close = () => {
    if (isOpen) area += `V${HEIGHT}Z`;
    isOpen = false;
  };
  for (let i = 0; i < values.length; i++) {
    const value = values[i];
    if (value === null || value === undefined) {
      close();
      continue;
    }
    x = Math.round((most - values.length + i) * step * 10) / 10;
    const y = Math.round((HEIGHT - 1 - Math.max(0, value) * scale) * 10) / 10;
    line += `${isOpen ? "L" : "M"}${x} ${y}`;
    area += isOpen ? `L${x} ${y}` : `M${x} ${HEIGHT}L${x} ${y}`;
    isOpen = true;
  }
  close();
  return { line, area };
}

export const Sparkline = {
  props: {
    values: { type: Array, default: () => [] },
    least: { type: Number, default: 1 }, // the upper edge is at least this: noise stays flat
    most: { type: Number, default: 120 }, // the number of values that fill the width
    label: { type: String, default: "" },
  },
  setup(props) {
    const paths = computed(() => {
      const values = props.values.slice(-props.most);
      let top = props.least;
      for (const value of values) if (value > top) top = value;
      return pathsOf(values, top * 1.2, props.most);
    });
    return { paths, WIDTH, HEIGHT };
  },
  template: `
    <svg class="sparkline" :width="WIDTH" :height="HEIGHT" :viewBox="'0 0 ' + WIDTH + ' ' + HEIGHT"
         role="img" :aria-label="label">
      <path class="spark-area" :d="paths.area" />
      <path class="spark-line" :d="paths.line" />
    </svg>`,
};
