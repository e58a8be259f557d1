// Publishes messages on a topic by a form made from its type.

import { ref, shallowReactive, watch } from "vue";
import { cancellable } from "page/feed.js";
import { isLive } from "page/shared/ros.js";
import { Problem, useProbe } from "page/shared/requests.js";
import { TypeForm } from "page/shared/type_form.js";

const MAX_TIMES = 100_000; // as the server
const sendings = new Map(); // topic -> what is published there; it outlives the panel

// {busy, result, error, send(fields), stop()}
function sendingOf(topic) {
  if (sendings.has(topic)) return sendings.get(topic);
  const state = shallowReactive({ busy: false, result: null, error: null });
  let cancel = null;
  const send = async (fields) => {
    Object.assign(state, { busy: true, result: null, error: null });
    const sent = cancellable("probe", { request: { do: "publish", topic, ...fields } });
    cancel = sent.cancel;
    try {
      state.result = (await sent.answer).result;
    } catch (error) {
      state.error = { message: error.message, hint: error.hint };
    } finally {
      state.busy = false;
    }
  };
  const stop = () => cancel?.().catch(() => {}); // without a connection the server stops it
  sendings.set(topic, Object.assign(state, { send, stop }));
  return state;
}

export const Publish = {
  components: { Problem, TypeForm },
  props: {
    topic: { type: String, required: true },
    type: { type: String, required: true },
    subscriptions: { type: Number, default: 0 },
  },
  setup(props) {
    const form = useProbe();
    const sending = sendingOf(props.topic); // the panel has a key for each topic
    const text = ref(null);
    const times = ref(1);
    const rateHz = ref(1);
    watch(
      () => [props.topic, props.type],
      () => {
        if (!sending.busy) Object.assign(sending, { result: null, error: null });
        form.clear();
        form.ask("form", { type: props.type });
      },
      { immediate: true },
    );
    const send = () => {
      const [count, rate] = [Number(times.value), Number(rateHz.value)];
      sending.send({
        type: props.type,
        values: text.value,
        times: count,
        rate_hz: rate,
        matched: Math.min(1, props.subscriptions), // it waits until one has been discovered
      });
    };
    return { form, sending, text, times, rateHz, send, isLive, MAX_TIMES };
  },
  template: `
    <div class="publish">
      <Problem :error="form.error" />
      <template v-if="form.result">
        <TypeForm :fields="form.result.fields" @text="text = $event" />
        <div class="row-buttons publish-send">
          <q-input v-model="times" dense outlined type="number" min="1" :max="MAX_TIMES"
                   label="times" class="short" />
          <q-input v-model="rateHz" dense outlined type="number" min="0.01" step="any" label="Hz"
                   class="short" />
          <q-btn unelevated no-caps color="primary" text-color="on-accent" icon="send"
                 label="Publish" data-action="publish"
                 :loading="sending.busy"
                 :disable="!isLive || text === null || !(times >= 1 && times <= MAX_TIMES) ||
                           !(rateHz > 0)"
                 @click="send" />
          <q-btn v-if="sending.busy" outline no-caps icon="stop" label="Stop"
                 data-action="stop-publish" :disable="!isLive" @click="sending.stop" />
        </div>
        <div v-if="sending.result" class="small" role="status" data-field="answer">
          Published {{ sending.result.published }}; {{ sending.result.matched }} subscriptions match
          besides those of this page.
        </div>
        <Problem :error="sending.error" />
      </template>
      <div v-else-if="form.busy" class="muted">Reading the type…</div>
    </div>`,
};
