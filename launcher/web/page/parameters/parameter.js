// One parameter of a node: its value, what it may be, and an editor.

import { computed, ref, watch } from "vue";
import { probe } from "page/feed.js";
import { parsed, parsedJson, textOf } from "page/shared/type_values.js";
import { isLive, isReadOnly } from "page/shared/ros.js";

const SLIDER_STEPS = 1e6; // a range with more has no slider

const kindOf = (type) =>
  /array/.test(type)
    ? "list"
    : type === "bool" || type === "boolean"
      ? "bool"
      : type === "integer" || type === "int"
        ? "integer"
        : type === "double" || type === "float"
          ? "double"
          : type === "string"
            ? "string"
            : "unset";

// The server sends integers that JavaScript would round as texts.
const exact = (type, list) => (/^int.*array/.test(type) ? list.map(BigInt) : list);

function shownText(kind, { type, value }) {
  if (value === null || value === undefined) return "";
  return kind === "list" ? textOf(exact(type, value)) : String(value);
}

// Whether a value came back as it was sent, perhaps with other blanks.
const isSame = (kind, sent, now) => kind === "list" && textOf(parsedJson(sent)) === now;

// What is wrong with a text for a parameter, or "".
function faultOf(kind, text, range) {
  if (kind === "list") {
    try {
      return Array.isArray(parsedJson(text)) ? "" : "a list in JSON is needed, such as [1, 2]";
    } catch (error) {
      return `a list in JSON is needed: ${error.message}`;
    }
  }
  if (kind === "integer" && !/^-?\d+$/.test(text.trim())) return "a whole number is needed";
  if (kind === "double" && (text.trim() === "" || !Number.isFinite(Number(text))))
    return "a number is needed";
  const number = Number(text);
  if (range && (number < range.from || number > range.to))
    return `from ${range.from} to ${range.to}`;
  return "";
}

// Emits "set" with the name after the node has accepted a value.
export const Parameter = {
  props: { node: { type: String, required: true }, parameter: { type: Object, required: true } },
  emits: ["set"],
  setup(props, { emit }) {
    const kind = computed(() => kindOf(props.parameter.type));
    const range = computed(() => props.parameter.integer_range ?? props.parameter.floating_range);
    const text = ref("");
    const accepted = ref(null);
    const busy = ref(false);
    const refusal = ref("");
    const hint = ref("");
    const done = ref(false);
    const given = computed(() => shownText(kind.value, props.parameter));
    watch(
      given,
      (now, before) => {
        const isEdited = before !== undefined && text.value !== before;
        const isMine = text.value === accepted.value;
        const isEcho = isMine && isSame(kind.value, text.value, now);
        if ((isEdited && !isMine) || isEcho) return;
        text.value = now;
        accepted.value = null;
      },
      { immediate: true },
    );
    const isChanged = computed(() => text.value !== given.value && text.value !== accepted.value);
    const fault = computed(() =>
      isChanged.value ? faultOf(kind.value, text.value, range.value) : "",
    );
    const canEdit = computed(
      () => !isReadOnly.value && !props.parameter.read_only && kind.value !== "unset",
    );
    const step = computed(() => {
      if (!range.value) return "any";
      return (
        range.value.step ||
        (kind.value === "integer" ? 1 : (range.value.to - range.value.from) / 200)
      );
    });
    const hasSlider = computed(
      () => range.value && (range.value.to - range.value.from) / step.value <= SLIDER_STEPS,
    );
    const rangeText = computed(() => {
      const one = range.value;
      return one ? `${one.from} to ${one.to}${one.step ? `, step ${one.step}` : ""}` : "";
    });
    const value = () => {
      if (kind.value === "integer") return parsed("int64", text.value);
      if (kind.value === "double") return Number(text.value);
      if (kind.value === "bool") return text.value === "true";
      return kind.value === "list" ? parsedJson(text.value) : text.value;
    };
    async function apply() {
      if (fault.value || !isChanged.value || busy.value) return;
      const sent = text.value;
      busy.value = true;
      refusal.value = hint.value = "";
      try {
        // As text: an integer may be larger than JavaScript's numbers.
        const values = textOf({ [props.parameter.name]: value() });
        const answer = (await probe("set_parameters", { node: props.node, values })).results[
          props.parameter.name
        ];
        if (answer.successful) {
          accepted.value = sent;
          done.value = true;
          setTimeout(() => (done.value = false), 2500);
          emit("set", props.parameter.name);
        } else refuse(answer.reason || "the node refused it and gave no reason");
      } catch (error) {
        refuse(error.message, error.hint);
      } finally {
        busy.value = false;
      }
    }
    const refuse = (message, advice) => {
      refusal.value = message;
      hint.value = advice ?? "";
      if (kind.value === "bool") text.value = given.value;
    };
    // A field of one line would drop the ends of lines.
    const isMultiline = computed(
      () => kind.value === "string" && `${given.value}${text.value}`.includes("\n"),
    );
    const entered = (event) => {
      if (isMultiline.value && !event.ctrlKey) return; // a new line
      event.preventDefault();
      apply();
    };
    const undo = () => {
      text.value = given.value;
      refusal.value = hint.value = "";
    };
    const toggle = (on) => {
      text.value = String(on);
      apply();
    };
    return {
      kind,
      range,
      text,
      busy,
      refusal,
      hint,
      done,
      given,
      isChanged,
      fault,
      canEdit,
      step,
      hasSlider,
      rangeText,
      apply,
      undo,
      isMultiline,
      entered,
      toggle,
      isLive,
    };
  },
  template: `
    <div class="parameter" :data-parameter="parameter.name" :data-changed="isChanged ? '' : null">
      <div class="parameter-about">
        <span class="mono parameter-name">{{ parameter.name }}</span>
        <span class="tag">{{ parameter.type }}</span>
        <span v-if="parameter.read_only" class="tag">
          <q-icon name="lock" size="11px" aria-hidden="true" /> read only
        </span>
        <div v-if="parameter.description" class="muted small">{{ parameter.description }}</div>
        <div v-if="rangeText" class="muted small" data-field="range">{{ rangeText }}</div>
        <div v-if="parameter.additional_constraints" class="muted small">
          {{ parameter.additional_constraints }}
        </div>
      </div>
      <div class="parameter-edit">
        <div v-if="!canEdit" class="mono tree-value" data-field="value">
          {{ given === "" ? "not set" : given }}
        </div>
        <q-toggle v-else-if="kind === 'bool'" dense :model-value="text === 'true'"
                  :disable="!isLive || busy"
                  :aria-label="parameter.name" :label="text" @update:model-value="toggle" />
        <template v-else>
          <div class="form-row">
            <q-input v-model="text" dense outlined class="form-input" input-class="mono"
                     :aria-label="parameter.name"
                     :inputmode="kind === 'integer' || kind === 'double' ? 'decimal' : 'text'"
                     :disable="!isLive"
                     :autogrow="isMultiline || (kind === 'list' && text.length > 40)"
                     :error="fault !== ''"
                     :error-message="fault"
                     hide-bottom-space @keydown.enter="entered" @keydown.esc.stop="undo" />
            <q-btn v-if="isChanged" unelevated dense no-caps color="primary" text-color="on-accent"
                   class="parameter-button" label="Set"
                   data-action="set" :loading="busy" :disable="fault !== '' || !isLive"
                   @click="apply" />
            <q-btn v-if="isChanged" flat dense round icon="undo" size="sm"
                   :aria-label="'Undo ' + parameter.name"
                   @click="undo" />
          </div>
          <input v-if="hasSlider" type="range" class="slider" :min="range.from" :max="range.to"
                 :step="step"
                 :value="text" :disabled="!isLive" :aria-label="'Slider of ' + parameter.name"
                 @input="text = $event.target.value" @change="apply" />
        </template>
        <div v-if="refusal" class="bad small" role="alert" data-field="refusal">
          <q-icon name="error" aria-hidden="true" /> {{ refusal }}
          <div v-if="hint" class="muted">hint: {{ hint }}</div>
        </div>
        <div v-else-if="done" class="good small" role="status" data-field="done">✓ set</div>
      </div>
    </div>`,
};
