// What `info` says of one process, and its last lines.

import { computed, onUnmounted, ref, shallowRef, watch } from "vue";
import { run } from "page/feed.js";
import { link as connection, log, processes } from "page/store.js";
import { bytes, clock, duration } from "page/format.js";
import { link } from "page/shared/address.js";
import { StateCell } from "page/processes/cells.js";
import { withoutPrefix } from "page/shared/prefix.js";
import { plain } from "page/shared/sgr.js";

const LAST_LINES = 20;
const REFRESH_MS = 5000;

// The words of a command line as a shell would need them.
const quoted = (words) =>
  words
    .map((word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`))
    .join(" ");

function factsOf(row, info) {
  const end = row.last_exit;
  const facts = [
    ["Pid", row.pid],
    ["Host", row.host],
    ["Up", row.uptime_s === null ? null : duration(row.uptime_s)],
    ["Restarts", row.restarts],
    ["Last exit", end && `${end.text}${end.asked ? ", requested" : ""}, at ${clock(end.wall_s)}`],
    ["Nodes", (row.node_names ?? []).join(", ")],
    ["Memory", row.uss_bytes && `${bytes(row.uss_bytes)} (USS)`],
    ["With shared memory", row.rss_bytes && `${bytes(row.rss_bytes)} (RSS)`],
    ["Threads, files", row.threads && `${row.threads}, ${row.fds}`],
  ];
  if (info) {
    facts.push(
      ["Package", info.package && `${info.package} / ${info.executable}`],
      ["Folder", info.cwd],
      ["Restarts by policy", info.restart_policy],
      ["Stops by", info.stop_policy],
      ["Start", info.start_text],
      ["Watched files", info.watched_files],
      ["Log file", info.log_file],
    );
  }
  return facts.filter(([, value]) => value !== null && value !== undefined && value !== "");
}

function lastLines(name) {
  const found = [];
  for (let i = log.rows.length - 1; i >= 0 && found.length < LAST_LINES; i--) {
    if (log.rows[i].process === name) found.unshift(log.rows[i]);
  }
  return found;
}

export const ProcessDrawer = {
  components: { StateCell },
  props: { name: { type: String, default: null } },
  emits: ["close"],
  setup(props) {
    const info = shallowRef(null);
    const problem = ref("");
    const filter = ref("");
    const row = computed(() => processes.value.find((one) => one.name === props.name) ?? null);
    const load = async () => {
      const name = props.name;
      if (!name || connection.state === "frozen") return;
      try {
        const found = await run("info", [name]);
        if (name === props.name) info.value = found.result.processes[0];
        problem.value = "";
      } catch (error) {
        problem.value = error.message;
      }
    };
    const open = () => {
      info.value = null;
      filter.value = "";
      load();
    };
    watch(() => props.name, open, { immediate: true });
    // A new life has another pid, command and environment.
    watch(() => row.value?.pid, load);
    const timer = setInterval(load, REFRESH_MS);
    onUnmounted(() => clearInterval(timer));
    const lines = computed(() => (log.version.value, props.name ? lastLines(props.name) : []));
    const environment = computed(() => {
      const all = Object.entries(info.value?.environment ?? {}).sort();
      const text = filter.value.toLowerCase();
      return all.filter(([key, value]) => `${key}=${value}`.toLowerCase().includes(text));
    });
    return {
      row, info, problem, filter, lines, environment, quoted, plain, withoutPrefix, clock, link,
      facts: computed(() => (row.value ? factsOf(row.value, info.value) : [])),
      isOpen: computed(() => props.name !== null),
      changed: computed(() => Object.entries(info.value?.env_set ?? {}).sort()),
    };
  },
  template: `
    <q-dialog :model-value="isOpen" position="right" full-height @hide="$emit('close')"
              @update:model-value="$event || $emit('close')">
      <q-card class="process-drawer" v-if="row" role="dialog" :aria-label="'Details of ' + row.name"
              :data-details="row.name">
        <div class="drawer-head">
          <div class="drawer-title" dir="auto">{{ row.name }}</div>
          <q-btn flat round dense icon="close" aria-label="Close (Escape)"
                 @click="$emit('close')" />
        </div>
        <div><StateCell :row="row" /></div>
        <div v-if="problem" class="bad">{{ problem }}</div>
        <dl class="facts">
          <template v-for="[key, value] in facts" :key="key">
            <dt>{{ key }}</dt><dd dir="auto">{{ value }}</dd>
          </template>
        </dl>
        <template v-if="info">
          <h3>Command line</h3>
          <pre class="code-block" dir="auto" data-field="command">{{ quoted(info.cmd) }}</pre>
          <h3 v-if="changed.length || info.env_unset.length">Environment it was given</h3>
          <pre class="code-block" v-if="changed.length" dir="auto"><template
            v-for="[key, value] in changed">{{ key }}={{ value }}\n</template></pre>
          <div v-if="info.env_unset.length" class="muted">
            without {{ info.env_unset.join(", ") }}</div>
          <details v-if="info.environment">
            <summary>Whole environment</summary>
            <q-input dense outlined v-model="filter" placeholder="Filter"
                     aria-label="Filter the environment" />
            <pre class="code-block" dir="auto" data-field="environment"><template
              v-for="[key, value] in environment">{{ key }}={{ value }}\n</template></pre>
          </details>
        </template>
        <h3>Last lines <a :href="link('log', { process: row.name })">in the log</a></h3>
        <ol class="code-block last-lines" data-field="lines">
          <li v-for="one in lines" :key="one.number" :data-level="one.level">
            <span class="muted">{{ clock(one.time) }}</span> <bdi
                 dir="auto">{{ withoutPrefix(plain(one.text), row.name).slice(0, 2000) }}</bdi>
          </li>
          <li v-if="!lines.length" class="muted">no lines</li>
        </ol>
      </q-card>
    </q-dialog>`,
};
