// Calls one service by a form made from its type.

import { ref, watch } from "vue";
import { duration } from "page/format.js";
import { isLive, isReadOnly } from "page/shared/ros.js";
import { Problem, useProbe } from "page/shared/requests.js";
import { TypeForm } from "page/shared/type_form.js";
import { ValueTree } from "page/shared/value_tree.js";

// Emits "called" with {service, type, values, wall, took_s, result, error}.
export const ServiceCall = {
  components: { Problem, TypeForm, ValueTree },
  props: { service: { type: String, required: true }, type: { type: String, required: true } },
  emits: ["called"],
  setup(props, { emit }) {
    const form = useProbe();
    const calling = useProbe();
    const text = ref(null);
    const timeoutS = ref(5);
    watch(
      () => props.type,
      (type) => form.ask("form", { type }),
      { immediate: true },
    );
    async function call() {
      const { service, type } = props;
      const values = text.value;
      const began = Date.now() / 1000;
      calling.result = null;
      const result = await calling.ask("call", {
        service,
        type,
        values,
        timeout_s: Number(timeoutS.value),
      });
      const error = result ? null : calling.error;
      emit("called", {
        service,
        type,
        values,
        wall: began,
        took_s: result?.took_s ?? Date.now() / 1000 - began,
        error,
        result: result?.values ?? null,
      });
    }
    return { form, calling, text, timeoutS, call, duration, isLive, isReadOnly };
  },
  template: `
    <div>
      <Problem :error="form.error" />
      <template v-if="form.result && !isReadOnly">
        <h3>Request</h3>
        <TypeForm :fields="form.result.request" @text="text = $event" />
        <div class="row-buttons">
          <q-input v-model="timeoutS" dense outlined type="number" min="0.1" step="any"
                   label="wait, s" class="short" />
          <q-btn unelevated no-caps color="primary" text-color="on-accent" icon="call_made"
                 label="Call" data-action="call"
                 :loading="calling.busy" :disable="!isLive || text === null || !(timeoutS > 0)"
                 @click="call" />
        </div>
      </template>
      <div v-else-if="isReadOnly" class="muted">This page only shows; it cannot call services.</div>
      <div v-else-if="form.busy" class="muted">Reading the type…</div>
      <Problem :error="calling.error" />
      <template v-if="calling.result">
        <h3>Response <span class="muted">after {{ duration(calling.result.took_s) }}</span></h3>
        <ValueTree :value="calling.result.values" data-field="response" />
      </template>
    </div>`,
};
