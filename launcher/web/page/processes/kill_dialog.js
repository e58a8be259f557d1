// Asks before SIGKILL is sent.

import { processCount } from "page/format.js";

const KILLS_ONE =
  "It ends at once and cannot clean up. Its restart policy is off until it is started again.";
const KILLS_SOME =
  "They end at once and cannot clean up. Their restart policies are off until they are started " +
  "again.";

export const KillDialog = {
  props: { names: { type: Array, default: null } }, // null: it is closed
  emits: ["cancel", "kill"],
  setup: () => ({ processCount, KILLS_ONE, KILLS_SOME }),
  template: `
    <q-dialog :model-value="names !== null" @update:model-value="$emit('cancel')">
      <q-card v-if="names" class="q-pa-md" role="alertdialog" aria-label="Kill?"
              data-asking="kill">
        <div class="text-subtitle1">Send SIGKILL to
          {{ names.length === 1 ? "this process" : processCount(names.length) }}?</div>
        <div class="mono ask-names"><bdi v-for="name in names" dir="auto">{{ name }}</bdi></div>
        <div class="muted">{{ names.length === 1 ? KILLS_ONE : KILLS_SOME }}</div>
        <div class="text-right q-mt-md">
          <q-btn flat no-caps label="Cancel" data-action="cancel" @click="$emit('cancel')"
                 autofocus />
          <q-btn outline no-caps color="negative" label="Kill" data-action="confirm-kill"
                 @click="$emit('kill')" />
        </div>
      </q-card>
    </q-dialog>`,
};
