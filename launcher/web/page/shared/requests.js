// What panels with forms share: a request with its state and answer.

import { shallowReactive } from "vue";
import { probe } from "page/feed.js";

// {busy, result, error: {message, hint}, ask(word, fields)}; a newer request replaces an older one.
export function useProbe() {
  const state = shallowReactive({ busy: false, result: null, error: null });
  let latest = 0;
  const ask = async (word, fields = {}) => {
    const mine = ++latest;
    state.busy = true;
    state.error = null;
    try {
      const result = await probe(word, fields);
      if (mine === latest) state.result = result;
      return result;
    } catch (error) {
      if (mine === latest) state.error = { message: error.message, hint: error.hint };
      return null;
    } finally {
      if (mine === latest) state.busy = false;
    }
  };
  const clear = () => {
    latest++;
    Object.assign(state, { busy: false, result: null, error: null });
  };
  return Object.assign(state, { ask, clear });
}

export const Problem = {
  props: { error: { type: Object, default: null } },
  template: `
    <div v-if="error" class="fault" role="alert" data-problem>
      <q-icon name="error" class="bad" aria-hidden="true" />
      <div>
        {{ error.message }}
        <div v-if="error.hint" class="muted">hint: {{ error.hint }}</div>
      </div>
    </div>`,
};
