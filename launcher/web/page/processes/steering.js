// Requests that change the run: whether they are possible, and what the launcher answered.

import { computed, reactive } from "vue";
import { run } from "page/feed.js";
import { hello, link } from "page/store.js";

const KEEP_ANSWERS = 30;
let nextAnswer = 1;

// Newest first: {key, title, state: "waiting" | "done" | "refused" | "unknown", lines, hint, at}.
export const answers = reactive([]);

// Frozen and read-only pages hide what changes something; without a connection it is disabled.
export const isSteerable = computed(() => link.state !== "frozen" && !hello.value?.read_only);
export const isConnected = computed(() => isSteerable.value && link.state === "open");

function title(verb, names) {
  const shown = names.slice(0, 3).join(", ");
  return names.length > 3 ? `${verb} ${shown} and ${names.length - 3} more` : `${verb} ${shown}`;
}

// Carry out a verb and keep its answer in the list; never throws.
export async function steer(verb, names, options = {}) {
  const words = options.signal ? `${verb} -s ${options.signal}` : verb;
  answers.unshift({
    key: nextAnswer++,
    title: title(words, names),
    state: "waiting",
    lines: [],
    hint: null,
    at: Date.now() / 1000,
  });
  answers.splice(KEEP_ANSWERS);
  const entry = answers[0];
  try {
    const found = await run(verb, names, options);
    const rows = found.result?.processes ?? [];
    const texts = found.text ?? [];
    entry.lines = texts.length ? texts : rows.map((row) => row.text);
    entry.state = rows.some((row) => row.done === false) ? "refused" : "done";
  } catch (error) {
    entry.state = error.code === "closed" ? "unknown" : "refused";
    entry.lines = [error.message];
    entry.hint = error.hint ?? null;
  }
}

export function forget(key) {
  const index = answers.findIndex((one) => one.key === key);
  if (index >= 0) answers.splice(index, 1);
}
