// What the launcher answered to requests of this page, newest first. It lies over the page, so that
// rows do not move under the pointer when an answer comes.

import { answers, forget } from "page/processes/steering.js";
import { clock } from "page/format.js";

const MARKS = {
  waiting: { icon: "hourglass_empty", word: "waits", tone: "muted" },
  done: { icon: "check_circle", word: "done", tone: "good" },
  unknown: { icon: "help_outline", word: "no answer", tone: "warn" },
  refused: { icon: "error", word: "not done", tone: "bad" },
};

export const AnswerList = {
  setup: () => ({ answers, forget, clock, MARKS, clear: () => answers.splice(0) }),
  template: `
    <section v-if="answers.length" class="answers card" aria-label="Answers of the launcher"
             data-answers>
      <div class="answers-head">
        <span class="muted">Answers of the launcher</span>
        <q-btn flat dense no-caps size="sm" icon="close" label="Close" @click="clear"
               data-action="clear-answers" />
      </div>
      <ul role="log" aria-live="polite" aria-label="Answers">
        <li v-for="one in answers" :key="one.key" :data-answer="one.state">
          <q-icon :name="MARKS[one.state].icon" :class="MARKS[one.state].tone" />
          <span class="mono muted">{{ clock(one.at) }}</span>
          <b dir="auto">{{ one.title }}</b>
          <span :class="MARKS[one.state].tone">{{ MARKS[one.state].word }}</span>
          <div class="answers-text">
            <div v-for="line in one.lines" dir="auto">{{ line }}</div>
            <div v-if="one.hint" class="muted" dir="auto">hint: {{ one.hint }}</div>
          </div>
          <q-btn flat round dense size="xs" icon="close"
                 :aria-label="'Remove the answer to ' + one.title"
                 @click="forget(one.key)" />
        </li>
      </ul>
    </section>`,
};
