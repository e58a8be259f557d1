// A form made from a type, and the same value as text (JSON, which is YAML, too).

import { computed, ref, watch } from "vue";
import {
  isFloat,
  isInteger,
  newItem,
  newValue,
  parsed,
  parsedJson,
  problem,
  problems,
  textOf,
} from "page/shared/type_values.js";

const VIEWS = ["form", "text"].map((value) => ({ label: value, value }));
const MOST_ROWS = 24; // longer lists of plain values are edited as text

// One value that is not a list.
const FieldValue = {
  name: "FieldValue",
  props: {
    field: { type: Object, required: true },
    modelValue: { default: null },
    path: String,
    label: String,
  },
  emits: ["update:modelValue"],
  setup(props, { emit }) {
    const constants = computed(() => Object.entries(props.field.constants ?? {}));
    const fault = computed(() => problem(props.field, props.modelValue));
    const take = (text) => emit("update:modelValue", parsed(props.field.type, text));
    const shown = computed(() => String(props.modelValue ?? ""));
    const isNumber = computed(() => isInteger(props.field.type) || isFloat(props.field.type));
    const member = (name, value) =>
      emit("update:modelValue", { ...props.modelValue, [name]: value });
    return { constants, fault, take, shown, isNumber, member };
  },
  template: `
    <fieldset v-if="field.fields" class="form-group" :data-path="path">
      <legend>{{ label }} <span class="muted small">{{ field.type }}</span></legend>
      <FormField v-for="one in field.fields" :key="one.name" :field="one"
                 :path="path + '.' + one.name"
                 :model-value="modelValue?.[one.name]"
                 @update:model-value="member(one.name, $event)" />
      <div v-if="!field.fields.length" class="muted small">no fields</div>
    </fieldset>
    <div v-else-if="field.type === 'bool'" class="form-row" :data-path="path">
      <q-toggle dense :model-value="Boolean(modelValue)" :label="label" :aria-label="path"
                @update:model-value="$emit('update:modelValue', $event)" />
    </div>
    <div v-else class="form-row" :data-path="path">
      <q-input dense outlined :model-value="shown" :label="label + '  ' + field.type"
               :aria-label="path"
               :inputmode="isNumber ? 'decimal' : 'text'" :error="fault !== ''"
               :error-message="fault"
               :hide-bottom-space="true"
               :autogrow="!isNumber && (shown.length > 60 || shown.includes('\\n'))"
               class="form-input"
               @update:model-value="take" />
      <select v-if="constants.length" class="form-select" :aria-label="'Constants for ' + path"
              :value="shown"
              @change="take($event.target.value)">
        <option value="" disabled>constant</option>
        <option v-for="[name, value] in constants" :key="name" :value="String(value)">
          {{ name }} = {{ value }}
        </option>
      </select>
    </div>`,
};

// One field: a value, or a list of values.
const FormField = {
  name: "FormField",
  components: { FieldValue },
  props: { field: { type: Object, required: true }, modelValue: { default: null }, path: String },
  emits: ["update:modelValue"],
  setup(props, { emit }) {
    const items = computed(() => (Array.isArray(props.modelValue) ? props.modelValue : []));
    const isText = computed(() => !props.field.fields && items.value.length > MOST_ROWS);
    const limit = computed(() => props.field.array?.size ?? props.field.array?.most ?? Infinity);
    const isFixed = computed(() => props.field.array?.size != null);
    const change = (index, value) =>
      emit(
        "update:modelValue",
        items.value.map((one, i) => (i === index ? value : one)),
      );
    const add = () => emit("update:modelValue", [...items.value, newItem(props.field)]);
    const remove = (index) =>
      emit(
        "update:modelValue",
        items.value.filter((_, i) => i !== index),
      );
    const listFault = ref("");
    const takeText = (text) => {
      try {
        const found = parsedJson(text);
        listFault.value = Array.isArray(found) ? "" : "a list is needed";
        if (Array.isArray(found)) emit("update:modelValue", found);
      } catch (error) {
        listFault.value = error.message;
      }
    };
    const kind = computed(() => {
      const { array, type } = props.field;
      return array
        ? `${type}[${array.size ?? (array.most === null ? "" : `<=${array.most}`)}]`
        : type;
    });
    return {
      items,
      isText,
      limit,
      isFixed,
      change,
      add,
      remove,
      takeText,
      listFault,
      kind,
      textOf,
    };
  },
  template: `
    <FieldValue v-if="!field.array" :field="field" :path="path" :label="field.name"
                :model-value="modelValue"
                @update:model-value="$emit('update:modelValue', $event)" />
    <fieldset v-else class="form-group" :data-path="path">
      <legend>
        {{ field.name }} <span class="muted small">{{ kind }}, {{ items.length }} items</span>
      </legend>
      <q-input v-if="isText" dense outlined type="textarea" rows="3" :model-value="textOf(items)"
               :aria-label="path"
               :error="listFault !== ''" :error-message="listFault" hide-bottom-space debounce="400"
               @update:model-value="takeText" />
      <template v-else>
        <div v-for="(one, index) in items" :key="index" class="form-item">
          <FieldValue :field="field" :path="path + '[' + index + ']'" :label="'[' + index + ']'"
                      :model-value="one"
                      @update:model-value="change(index, $event)" class="form-item-value" />
          <q-btn v-if="!isFixed" flat round dense size="sm" icon="close"
                 :aria-label="'Remove ' + path + '[' + index + ']'"
                 @click="remove(index)" />
        </div>
      </template>
      <q-btn v-if="!isFixed && items.length < limit" flat dense no-caps size="sm" icon="add"
             label="Add"
             :aria-label="'Add to ' + path" @click="add" />
    </fieldset>`,
};
FieldValue.components = { FormField };

// v-model: the value. Emits "text" with what is to be sent, or null while something is wrong.
export const TypeForm = {
  components: { FormField },
  props: { fields: { type: Array, required: true } },
  emits: ["text"],
  setup(props, { emit }) {
    const value = ref({});
    const view = ref("form");
    const text = ref("");
    const note = ref("");
    const faults = computed(() =>
      view.value === "form" ? problems(props.fields, value.value) : [],
    );
    const member = (name, held) => (value.value = { ...value.value, [name]: held });
    const reset = () => {
      value.value = newValue(props.fields);
      text.value = textOf(value.value);
    };
    watch(() => props.fields, reset, { immediate: true });
    watch(
      [value, text, view],
      () =>
        emit(
          "text",
          view.value === "text" ? text.value : faults.value.length ? null : textOf(value.value),
        ),
      { immediate: true },
    );
    const show = (name) => {
      note.value = "";
      if (name === "text") text.value = textOf(value.value);
      else if (!takeText()) return;
      view.value = name;
    };
    const takeText = () => {
      try {
        const found = parsedJson(text.value || "{}");
        value.value = { ...newValue(props.fields), ...found };
        return true;
      } catch (error) {
        note.value = `The form can only show JSON: ${error.message}`;
        return false;
      }
    };
    return { VIEWS, value, view, text, note, faults, member, reset, show };
  },
  template: `
    <div class="type-form">
      <div class="row-buttons">
        <q-btn-toggle :model-value="view" dense no-caps unelevated toggle-color="primary"
                      toggle-text-color="on-accent" padding="2px 10px"
                      :options="VIEWS"
                      @update:model-value="show" />
        <q-btn flat dense no-caps size="sm" label="Defaults" @click="reset" />
      </div>
      <template v-if="view === 'form'">
        <FormField v-for="one in fields" :key="one.name" :field="one" :path="one.name"
                   :model-value="value[one.name]" @update:model-value="member(one.name, $event)" />
        <div v-if="!fields.length" class="muted small">This type has no fields.</div>
        <div v-if="faults.length" class="bad small" role="status">
          {{ faults[0].path }}: {{ faults[0].text }}
        </div>
      </template>
      <template v-else>
        <q-input v-model="text" dense outlined type="textarea" rows="8" input-class="mono"
                 aria-label="JSON or YAML" />
        <div v-if="note" class="bad small" role="status">{{ note }}</div>
      </template>
    </div>`,
};
