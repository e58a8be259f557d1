// The search field of a panel: `/` goes to it, Escape empties it (app.js). What is given between
// its tags comes at its end.

export const SearchField = {
  props: {
    modelValue: { type: String, required: true },
    label: { type: String, required: true },
    placeholder: { type: String, default: "Filter (/)" },
    isWrong: { type: Boolean, default: false },
  },
  emits: ["update:modelValue"],
  template: `
    <div class="panel-search" data-search>
      <q-input dense outlined clearable :model-value="modelValue" :placeholder="placeholder"
               :aria-label="label" :error="isWrong" hide-bottom-space
               @update:model-value="$emit('update:modelValue', $event ?? '')">
        <template #prepend><q-icon name="search" size="18px" /></template>
        <template v-if="$slots.default" #append><slot /></template>
      </q-input>
    </div>`,
};
