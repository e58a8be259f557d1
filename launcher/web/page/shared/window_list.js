// A list of any length that draws only the rows in view. Rows have one height, or wrap.
//
// The view stays where it is while the space behind it scrolls: a scroll position of `row height`
// times N means that row N is at the top. With wrapped rows, whose heights are not known before
// they are drawn, one can scroll until the last row is at the top; the end is drawn at the bottom.

import { computed, nextTick, onMounted, onUnmounted, ref, watch } from "vue";

export const WindowList = {
  props: {
    rows: { type: Array, required: true },
    version: { type: Number, required: true }, // another one when `rows` has changed
    keyOf: { type: Function, required: true }, // a number that grows from row to row
    rowHeight: { type: Number, default: 20 },
    isFollowing: { type: Boolean, default: false },
    isWrapped: { type: Boolean, default: false },
    label: { type: String, required: true },
  },
  emits: ["follow"],
  setup(props, { emit, expose }) {
    const scroller = ref(null);
    const view = ref(null);
    const body = ref(null);
    const height = ref(0);
    const top = ref(0); // index of the first row, with a fraction
    const shift = ref(0);
    let expected = -1; // the scroll position that the list itself has set
    let before = 0; // the last scroll position
    let anchor = null; // {key, fraction} of the row at the top

    const visible = computed(() => Math.ceil(height.value / props.rowHeight) + 1);
    const total = computed(() => {
      void props.version;
      const lines = props.isWrapped ? props.rows.length - 1 : props.rows.length;
      return Math.max(0, lines * props.rowHeight + (props.isWrapped ? height.value : 0));
    });
    const start = computed(() => {
      void props.version;
      const end = Math.max(0, props.rows.length - visible.value);
      if (props.isFollowing) return end;
      return Math.max(0, Math.min(Math.floor(top.value), props.rows.length - 1));
    });
    const shown = computed(() => {
      void props.version;
      return props.rows.slice(start.value, start.value + visible.value);
    });
    // A list that is shorter than the view begins at its top.
    const isAtBottom = computed(() => {
      void props.version;
      const isLong = props.isWrapped || props.rows.length * props.rowHeight > height.value;
      return props.isFollowing && isLong;
    });

    const scrollTo = (position) => {
      if (!scroller.value) return;
      scroller.value.scrollTop = position;
      expected = before = scroller.value.scrollTop;
      top.value = before / props.rowHeight;
      keepAnchor();
    };
    const keepAnchor = () => {
      const row = props.rows[Math.floor(top.value)];
      anchor = row ? { key: props.keyOf(row), fraction: top.value % 1 } : null;
      nextTick(placeFirst);
    };
    const placeFirst = () => {
      const first = body.value?.firstElementChild;
      shift.value = first ? (top.value - start.value) * first.offsetHeight : 0;
    };
    const firstVisible = () => {
      const edge = view.value.getBoundingClientRect().top;
      const rows = [...body.value.children];
      const index = rows.findIndex((one) => one.getBoundingClientRect().bottom > edge);
      return start.value + Math.max(0, index);
    };
    const isEndVisible = () => {
      if (start.value + visible.value < props.rows.length) return false;
      const last = body.value.lastElementChild;
      const bottom = (element) => element.getBoundingClientRect().bottom;
      return !last || bottom(last) <= bottom(view.value) + 2;
    };
    const scrolled = () => {
      if (!scroller.value) return; // a last event of a list that is gone
      const position = scroller.value.scrollTop;
      if (Math.abs(position - expected) < 1) {
        before = position;
        return;
      }
      expected = -1;
      const delta = position - before;
      before = position;
      if (props.isFollowing) {
        if (delta >= 0) return;
        emit("follow", false);
        if (props.isWrapped) return scrollTo(firstVisible() * props.rowHeight + delta);
      }
      top.value = position / props.rowHeight;
      keepAnchor();
      if (delta > 0) nextTick(() => isEndVisible() && emit("follow", true));
    };
    // At once: lines that come in would move the end away before the position is seen.
    const wheeled = (event) => {
      const isLong = props.rows.length * props.rowHeight > height.value || props.isWrapped;
      if (event.deltaY < 0 && props.isFollowing && isLong) {
        emit("follow", false);
        if (props.isWrapped) scrollTo(firstVisible() * props.rowHeight);
      }
    };
    // Show the row with this key, or the next one, in the upper third.
    const reveal = async (key) => {
      emit("follow", false);
      await nextTick();
      const index = indexOf(key);
      const lines = props.isWrapped ? 2 : Math.floor(visible.value / 3);
      scrollTo(Math.max(0, (index - lines) * props.rowHeight));
    };
    const indexOf = (key) => {
      let [low, high] = [0, props.rows.length];
      while (low < high) {
        const middle = (low + high) >> 1;
        if (props.keyOf(props.rows[middle]) < key) low = middle + 1;
        else high = middle;
      }
      return low;
    };
    // After a change of the rows the same row stays at the top, or the end at the bottom.
    const settle = () => {
      if (!scroller.value) return;
      if (props.isFollowing) scrollTo(scroller.value.scrollHeight);
      else if (anchor) {
        const index = indexOf(anchor.key);
        const row = props.rows[index];
        const isSame = row && props.keyOf(row) === anchor.key;
        const place = (index + (isSame ? anchor.fraction : 0)) * props.rowHeight;
        if (Math.abs(place - scroller.value.scrollTop) >= 1) scrollTo(place);
        else nextTick(placeFirst);
      } else keepAnchor();
    };
    const causes = () => [props.version, props.isFollowing, props.isWrapped, height.value];
    watch(causes, settle, { flush: "post" });
    const observer = new ResizeObserver(() => (height.value = view.value?.clientHeight ?? 0));
    onMounted(() => {
      observer.observe(scroller.value);
      observer.observe(body.value);
      height.value = view.value.clientHeight;
    });
    onUnmounted(() => observer.disconnect());
    expose({ reveal, firstIndex: () => start.value, focus: () => scroller.value?.focus() });
    return { scroller, view, body, height, total, shown, shift, isAtBottom, scrolled, wheeled };
  },
  template: `
    <div class="window" ref="scroller" tabindex="0" role="region" :aria-label="label"
         :data-following="isFollowing" @scroll.passive="scrolled" @wheel.passive="wheeled">
      <div class="window-view" ref="view" :class="{ wrapped: isWrapped }">
        <div class="window-rows" ref="body" :class="{ 'at-bottom': isAtBottom }"
             :style="isAtBottom ? {} : { transform: 'translateY(' + -shift + 'px)' }">
          <slot v-for="row in shown" :key="keyOf(row)" :row="row" />
        </div>
      </div>
      <div :style="{ height: Math.max(0, total - height) + 'px' }"></div>
    </div>`,
};
