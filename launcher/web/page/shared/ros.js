// What the panels about the ROS graph share.

import { computed, onUnmounted, ref, watch } from "vue";
import { subscribe } from "page/feed.js";
import { hello, link } from "page/store.js";
import { duration, rate } from "page/format.js";
import { goTo } from "page/shared/address.js";

export const isFrozen = computed(() => link.state === "frozen");
export const isReadOnly = computed(() => isFrozen.value || Boolean(hello.value?.read_only));
// Whether requests can be sent now.
export const isLive = computed(() => link.state === "open");

// Subscribe while a panel is shown; `of` returns the fields, or null for nothing.
export function useSubscription(word, of = () => ({})) {
  let end = null;
  const begin = (fields) => {
    end?.();
    end = fields === null || isFrozen.value ? null : subscribe(word, fields);
  };
  watch(
    () => JSON.stringify(of()),
    () => begin(of()),
    { immediate: true },
  );
  onUnmounted(() => end?.());
}

// Says that what a panel shows of the graph is old, and why.
export const ProbeProblem = {
  setup() {
    const reason = computed(() => {
      const state = hello.value?.graph;
      return isFrozen.value || !state || state.available ? "" : state.reason;
    });
    return { reason };
  },
  template: `
    <div v-if="reason" class="fault" role="alert" data-probe-problem>
      <q-icon name="error" class="bad" aria-hidden="true" />
      <div>The ROS graph cannot be read: {{ reason }}</div>
    </div>`,
};

// The traffic of a topic in a few words.
export function trafficText(one) {
  if (!one) return "";
  if (one.state === "failed") return "not measured";
  if (one.age_s === null || one.age_s === undefined)
    return one.state === "waiting" ? "" : "no messages";
  if (!one.rate_hz) return `silent for ${duration(one.age_s)}`;
  return `${rate(one.rate_hz)} Hz · ${duration(one.age_s)}`;
}

export const showLog = (process) => goTo("log", { process });

const INFINITE_NS = 9223372036854775807;

export function qosText(one) {
  const parts = [one.reliability, one.durability];
  if (one.deadline_ns < INFINITE_NS) parts.push(`deadline ${one.deadline_ns / 1e9} s`);
  if (one.liveliness !== "AUTOMATIC") parts.push(one.liveliness);
  if (one.lease_ns < INFINITE_NS) parts.push(`lease ${one.lease_ns / 1e9} s`);
  return parts.join(", ");
}

export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = document.createElement("textarea"); // without https there is no clipboard
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
}

// The width of the window as a ref, for what style sheets cannot decide.
export function useNarrow(limit) {
  const query = matchMedia(`(max-width: ${limit}px)`);
  const isNarrow = ref(query.matches);
  const changed = () => (isNarrow.value = query.matches);
  query.addEventListener("change", changed);
  onUnmounted(() => query.removeEventListener("change", changed));
  return isNarrow;
}
