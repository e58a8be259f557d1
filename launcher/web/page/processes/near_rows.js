// Which rows of a list are in view or close to it. Only these are drawn with all they have: with 300
// processes the others would be most of the page, and be compared every second.

import { onUnmounted, ref, shallowReactive } from "vue";

const MARGIN_PX = 400;
const LEAST_PX = 30; // the lowest row there may be

// The name of the row that has the focus, or whose last error has it.
function focusedRow() {
  const row = document.activeElement?.closest("[data-process], [data-error-of]");
  return row?.dataset.process ?? row?.dataset.errorOf;
}

// {isNear, observer, heightOf} for rows with `data-process`; `vNear` gets the observer as its value.
export function useNearRows(rows) {
  const first = rows.slice(0, Math.ceil(window.innerHeight / LEAST_PX));
  const near = shallowReactive(new Set(first.map((row) => row.name)));
  const heights = new Map(); // of rows that have left the view, so that nothing moves with them
  const isPrinting = ref(false); // paper has no view
  const observer = new IntersectionObserver(
    (entries) => {
      const focused = focusedRow(); // the focus would be lost with the button that has it
      for (const { target, isIntersecting, boundingClientRect } of entries) {
        const name = target.dataset.process;
        if (isIntersecting || name === focused) near.add(name);
        else if (near.delete(name)) heights.set(name, boundingClientRect.height);
        if (!target.isConnected) heights.delete(name);
      }
    },
    { rootMargin: `${MARGIN_PX}px` },
  );
  const print = (event) => (isPrinting.value = event.type === "beforeprint");
  for (const event of ["beforeprint", "afterprint"]) window.addEventListener(event, print);
  onUnmounted(() => {
    observer.disconnect();
    for (const event of ["beforeprint", "afterprint"]) window.removeEventListener(event, print);
  });
  const isNear = (name) => isPrinting.value || near.has(name);
  const heightOf = (name) =>
    !isNear(name) && heights.has(name) ? { height: `${heights.get(name)}px` } : null;
  return { isNear, observer, heightOf };
}

export const vNear = {
  mounted: (element, { value }) => value.observe(element),
  unmounted: (element, { value }) => value.unobserve(element),
};
