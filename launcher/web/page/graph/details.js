// What is known of the node, topic or folded namespace that is chosen in the graph.

import { computed } from "vue";
import { request } from "page/feed.js";
import { graph, messages, traffic } from "page/store.js";
import { bytes, clock } from "page/format.js";
import { repairs, sentence } from "page/graph/model.js";
import { isLive, qosText, showLog, trafficText, useSubscription } from "page/shared/ros.js";
import { goTo } from "page/shared/address.js";
import { ValueTree } from "page/shared/value_tree.js";

export const GraphDetails = {
  components: { ValueTree },
  props: { item: { type: Object, required: true } },
  emits: ["close", "choose", "unfold"],
  setup(props) {
    const isTopic = computed(() => props.item.kind === "topic");
    const topicName = computed(() => (isTopic.value ? props.item.name : null));
    useSubscription("echo", () => (topicName.value === null ? null : { topic: topicName.value }));
    const endpoints = computed(() =>
      (graph.value?.endpoints ?? []).filter(
        (one) => (isTopic.value ? one.topic : one.node) === props.item.name,
      ),
    );
    const groups = computed(() =>
      [
        ["publisher", "Publishers", "Publishes"],
        ["subscription", "Subscriptions", "Subscribes to"],
      ].map(([direction, ofTopic, ofNode]) => ({
        title: isTopic.value ? ofTopic : ofNode,
        rows: endpoints.value.filter((one) => one.direction === direction),
      })),
    );
    const faults = computed(() =>
      (graph.value?.mismatches ?? []).filter((one) =>
        isTopic.value
          ? one.topic === props.item.name
          : one.subscription === props.item.name || one.publishers.includes(props.item.name),
      ),
    );
    const last = computed(() => messages.get(topicName.value)?.at(-1) ?? null);
    const moving = computed(() => traffic.value[topicName.value]);
    const other = (one) => (isTopic.value ? one.node : one.topic);
    const otherId = (one) => (isTopic.value ? `n ${one.node}` : `t ${one.topic}`);
    const types = computed(() => props.item.topic?.types.join(", ") ?? "");
    const forget = () => request("forget", { node: props.item.name }).catch(() => {});
    const states = {
      running: "running",
      ghost: "gone: its process ended, DDS still lists it",
      gone: "gone",
    };
    return {
      isTopic,
      groups,
      faults,
      last,
      moving,
      other,
      otherId,
      types,
      forget,
      states,
      sentence,
      repairs,
      qosText,
      showLog,
      trafficText,
      bytes,
      clock,
      goTo,
      isLive,
    };
  },
  template: `
    <aside class="details" :data-details="item.name" aria-label="Details">
      <div class="details-head">
        <span class="tag">{{ item.kind === "fold" ? "namespace" : item.kind }}</span>
        <h2 class="details-title">{{ item.name }}</h2>
        <q-btn flat round dense icon="close" aria-label="Close details" @click="$emit('close')" />
      </div>

      <template v-if="item.kind === 'fold'">
        <q-btn outline no-caps dense class="q-mb-sm" icon="unfold_more" label="Unfold"
               @click="$emit('unfold', item.name)" />
        <h3>Nodes</h3>
        <div v-for="name in item.members" :key="name" class="mono">{{ name }}</div>
      </template>

      <dl v-if="item.kind === 'node'" class="facts">
        <dt>State</dt>
        <dd data-field="state">{{ states[item.state] }}<template v-if="item.node.since">
          since {{ clock(item.node.since) }}</template></dd>
        <dt>Process</dt>
        <dd>
          <a v-if="item.node.process" href="#/log" data-field="process"
             @click.prevent="showLog(item.node.process)">{{ item.node.process }}, its log</a>
          <span v-else class="muted">not of this run</span>
          <span v-if="item.node.pid" class="muted"> pid {{ item.node.pid }}</span>
        </dd>
      </dl>
      <div v-if="item.kind === 'node'" class="row-buttons">
        <q-btn v-if="item.state === 'running'" outline no-caps dense icon="tune" label="Parameters"
               @click="goTo('parameters', { node: item.name })" />
        <q-btn v-if="item.state === 'gone' && isLive" outline no-caps dense icon="clear"
               label="Forget"
               data-action="forget" @click="forget" />
      </div>

      <dl v-if="isTopic" class="facts">
        <dt>Type</dt><dd class="mono" data-field="type">{{ types }}</dd>
        <dt>Traffic</dt>
        <dd data-field="traffic">
          {{ trafficText(moving) || "–" }}
          <template v-if="moving?.bytes_per_s">· {{ bytes(moving.bytes_per_s) }}/s</template>
        </dd>
        <template v-if="item.isLatched"><dt>Latched</dt>
          <dd>a publisher keeps its last messages for late subscribers (TRANSIENT_LOCAL)</dd>
        </template>
      </dl>
      <div v-if="isTopic" class="row-buttons">
        <q-btn outline no-caps dense icon="show_chart" label="Echo and plot"
               @click="goTo('topics', { topic: item.name })" />
      </div>

      <div v-for="one in faults" :key="sentence(one)" class="fault" role="note">
        <q-icon name="error" class="bad" aria-hidden="true" />
        <div>
          {{ sentence(one) }}
          <div v-for="text in repairs(one)" :key="text" class="muted">{{ text }}</div>
        </div>
      </div>

      <template v-if="item.kind !== 'fold'">
        <template v-for="group in groups" :key="group.title">
          <h3>{{ group.title }} <span class="muted">{{ group.rows.length }}</span></h3>
          <div v-for="one in group.rows" :key="one.gid + one.topic + one.node" class="endpoint"
               :data-endpoint="other(one)">
            <button type="button" class="link mono" @click="$emit('choose', otherId(one))">
              {{ other(one) }}
            </button>
            <span v-if="one.ghost" class="tag">gone</span>
            <div class="muted small">{{ qosText(one) }}</div>
            <div v-if="types !== one.type" class="muted small mono">{{ one.type }}</div>
          </div>
          <div v-if="!group.rows.length" class="muted small">none</div>
        </template>
      </template>

      <template v-if="isTopic">
        <h3>Last message <span class="muted" v-if="last">{{ clock(last.wall, true) }}</span></h3>
        <ValueTree v-if="last" :value="last.data" data-field="last" />
        <div v-else class="muted small">none since this was opened</div>
      </template>
    </aside>`,
};
