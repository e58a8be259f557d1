// The list of keys, of all panels. It is drawn when it is first opened: templates are compiled in
// the browser, and what the first picture does not have shall not delay it.

export const KeyList = {
  props: { modelValue: { type: Boolean, required: true }, panels: { type: Array, required: true } },
  emits: ["update:modelValue"],
  template: `
    <q-dialog :model-value="modelValue" @update:model-value="$emit('update:modelValue', $event)">
      <q-card class="q-pa-md">
        <div class="text-h6">Keys</div>
        <table class="keys">
          <tr v-for="one in panels"><td><kbd>{{ one.key }}</kbd></td><td>{{ one.label }}</td></tr>
          <tr><td><kbd>/</kbd></td><td>search</td></tr>
          <tr><td><kbd>↑</kbd> <kbd>↓</kbd> <kbd>Space</kbd> <kbd>Enter</kbd></td>
            <td>processes: move, select, details</td></tr>
          <tr><td><kbd>s</kbd> <kbd>r</kbd> <kbd>k</kbd> <kbd>m</kbd></td>
            <td>processes: stop, restart, kill, mute</td></tr>
          <tr><td><kbd>e</kbd> <kbd>n</kbd> <kbd>N</kbd></td>
            <td>log: first error, next one, the one before</td></tr>
          <tr><td><kbd>f</kbd> <kbd>w</kbd></td><td>log: follow the end, wrap lines</td></tr>
          <tr><td><kbd>+</kbd> <kbd>-</kbd> <kbd>←</kbd> <kbd>→</kbd></td>
            <td>timeline: zoom, move</td></tr>
          <tr><td><kbd>a</kbd> <kbd>l</kbd></td><td>timeline: all, last minute</td></tr>
          <tr><td><kbd>t</kbd></td><td>light or dark</td></tr>
          <tr><td><kbd>?</kbd></td><td>this list</td></tr>
        </table>
      </q-card>
    </q-dialog>`,
};
