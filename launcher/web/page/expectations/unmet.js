// What a failed run of smoke did not meet, above all panels of its report.

import { computed } from "vue";
import { chosen, expectations, link as connection } from "page/store.js";
import { clock } from "page/format.js";
import { link } from "page/shared/address.js";

function headline(unmet, all) {
  const were = unmet === 1 ? "was" : "were";
  return `${unmet} of ${all} ${all === 1 ? "expectation" : "expectations"} ${were} not met`;
}

const hasMoment = (one) => one.wall !== null && one.wall !== undefined;

export const UnmetList = {
  setup() {
    const unmet = computed(() => expectations.value.filter((one) => one.state === "failed"));
    return {
      unmet, hasMoment, clock,
      // A live page shows expectations in its timeline: there they may still change.
      isShown: computed(() => connection.state === "frozen" && unmet.value.length > 0),
      title: computed(() => headline(unmet.value.length, expectations.value.length)),
      logOf: (one) => link("log", { at: one.wall.toFixed(3) }),
      choose: (one) => (chosen.moment = one.wall),
    };
  },
  template: `
    <details v-if="isShown" open class="app-banner unmet" role="status" data-unmet>
      <summary><q-icon name="cancel" class="bad" aria-hidden="true" /> <b>{{ title }}</b></summary>
      <ul>
        <li v-for="(one, index) in unmet" :key="index" :data-expectation="one.title">
          <b dir="auto">{{ one.title }}</b>
          <span v-if="one.detail" class="unmet-detail" dir="auto">{{ one.detail }}</span>
          <span v-if="hasMoment(one)" class="unmet-links">
            <span class="mono muted">{{ clock(one.wall, true) }}</span>
            <a href="#/timeline" data-action="unmet-to-timeline"
               @click="choose(one)">in the timeline</a>
            <a :href="logOf(one)" data-action="unmet-to-log">in the log</a>
          </span>
        </li>
      </ul>
    </details>`,
};
