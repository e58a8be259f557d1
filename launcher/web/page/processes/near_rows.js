// Which rows of a list are in view or close to it. Only these are drawn with all they have: with 300
// processes the others would be most of the page, and be compared every second.

import { onUnmounted, shallowReactive } from "vue";

const MARGIN_PX = 400;
const LEAST_PX = 30; // the lowest row there may be

// {near, observer, heightOf} for rows with `data-process`; `vNear` gets the observer as its value.
export function useNearRows(rows) {
  const first = rows.slice(0, Math.ceil(window.innerHeight / LEAST_PX));
  const near = shallowReactive(new Set(first.map((row) => row.name)));
  const heights = new Map(); // of rows that have left the view, so that nothing moves with them
  const observer = new IntersectionObserver(
    (entries) => {
      for (const { target, isIntersecting, boundingClientRect } of entries) {
        const name = target.dataset.process;
        if (isIntersecting) near.add(name);
        else if (near.delete(name)) heights.set(name, boundingClientRect.height);
        if (!target.isConnected) heights.delete(name);
      }
    },
    { rootMargin: `${MARGIN_PX}px` },
  );
  onUnmounted(() => observer.disconnect());
  const heightOf = (name) => (heights.get(name) ? { height: `${heights.get(name)}px` } : null);
  return { near, observer, heightOf };
}

export const vNear = {
  mounted: (element, { value }) => value.observe(element),
  unmounted: (element, { value }) => value.unobserve(element),
};
