// The tree of frames beside the graph, while transforms are published.

import { computed, onUnmounted, watch } from "vue";
import { graph } from "page/store.js";
import { isLive } from "page/shared/ros.js";
import { Problem, useProbe } from "page/shared/requests.js";

const TYPE = "tf2_msgs/msg/TFMessage";
const PERIOD_MS = 2000;

export const FrameTree = {
  components: { Problem },
  setup() {
    const answer = useProbe();
    const isShown = computed(
      () => isLive.value && (graph.value?.topics ?? []).some((one) => one.types.includes(TYPE)),
    );
    let timer = null;
    const end = () => clearInterval(timer);
    watch(
      isShown,
      (now) => {
        end();
        if (!now) return;
        const ask = () => answer.busy || answer.ask("frames");
        ask();
        timer = setInterval(ask, PERIOD_MS);
      },
      { immediate: true },
    );
    onUnmounted(end);
    return { answer, isShown };
  },
  template: `
    <aside v-if="isShown" class="frames" aria-label="Frames">
      <b>Frames</b>
      <Problem :error="answer.error" />
      <div v-for="text in answer.result?.problems ?? []" :key="text" class="bad small" data-problem>
        {{ text }}
      </div>
      <div v-for="[frame, facts] in answer.result?.rows ?? []" :key="frame" class="frame"
           :title="facts" data-frame>
        <span class="mono" dir="auto">{{ frame }}</span> <span class="muted small">{{ facts }}</span>
      </div>
    </aside>`,
};
