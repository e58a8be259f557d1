// The processes as a dense table, or as a list of cards where it is narrow.

import { ActionButtons, ErrorCell, SparkCell, StateCell } from "page/processes/cells.js";
import { useNearRows, vNear } from "page/processes/near_rows.js";
import { errorOf, fitsOf } from "page/processes/rows.js";
import { isSteerable } from "page/processes/steering.js";

const PROPS = {
  rows: { type: Array, required: true },
  columns: { type: Array, required: true },
  selected: { type: Set, required: true },
  cursor: { type: String, default: null },
  order: { type: Object, required: true }, // {by, isDescending}
  isWide: { type: Boolean, default: true }, // else the last error has a separate line
};
const PARTS = { ActionButtons, ErrorCell, SparkCell, StateCell };

export const ProcessTable = {
  components: PARTS,
  directives: { near: vNear },
  props: PROPS,
  emits: ["sort", "pick", "pick-all", "open", "act", "focus"],
  setup(props) {
    const direction = (column) => {
      if (props.order.by !== column.name) return "none";
      return props.order.isDescending ? "descending" : "ascending";
    };
    const count = () => props.rows.filter((row) => props.selected.has(row.name)).length;
    const isAll = () => props.rows.length > 0 && count() === props.rows.length;
    const isSome = () => !isAll() && count() > 0;
    return {
      direction, isAll, isSome, errorOf, fitsOf, isSteerable, ...useNearRows(props.rows),
    };
  },
  template: `
    <q-markup-table dense flat bordered class="process-table" :class="{ wide: isWide }"
                    aria-label="Processes">
      <thead>
        <tr>
          <th class="process-check">
            <input type="checkbox" aria-label="Select all" data-action="select-all"
                   :checked="isAll()" :indeterminate.prop="isSome()" @change="$emit('pick-all')">
          </th>
          <template v-for="column in columns" :key="column.name">
          <th v-if="column.name === 'error' && isSteerable" class="text-left">Actions</th>
          <th :aria-sort="direction(column)" :data-column="column.name"
              :class="{ 'text-right': column.isNumber, 'text-left': !column.isNumber }">
            <button type="button" class="sort" :data-sort="column.name"
                    @click="$emit('sort', column.name)">
              {{ column.label }}<span aria-hidden="true">{{
                { none: "", ascending: " ▲", descending: " ▼" }[direction(column)] }}</span>
            </button>
          </th>
          </template>
          <th v-if="!isWide && isSteerable" class="text-left">Actions</th>
        </tr>
      </thead>
      <tbody>
        <template v-for="row in rows" :key="row.name">
        <tr :data-process="row.name" :data-state="row.state" v-near="observer"
            :tabindex="row.name === cursor ? 0 : -1" :aria-selected="selected.has(row.name)"
            :class="{ chosen: selected.has(row.name), 'has-error': !isWide && errorOf(row) }"
            :style="heightOf(row.name)"
            @focus="$emit('focus', row.name)" @dblclick="$emit('open', row.name)">
          <template v-if="isNear(row.name)">
            <td class="process-check">
              <input type="checkbox" :checked="selected.has(row.name)"
                     :aria-label="'Select ' + row.name"
                     @click="$emit('pick', row.name, $event.shiftKey)" @dblclick.stop>
            </td>
            <template v-for="column in columns" :key="column.name">
              <td v-if="column.name === 'state'" class="process-state-cell">
                <StateCell :row="row" />
              </td>
              <td v-else-if="column.name === 'name'" data-column="name">
                <button type="button" class="process-name" @click="$emit('open', row.name)">
                  <bdi dir="auto">{{ row.name }}</bdi>
                </button>
              </td>
              <template v-else-if="column.name === 'error'">
              <td v-if="isSteerable">
                <ActionButtons :fits="fitsOf([row])" :label="row.name"
                               @act="$emit('act', $event, [row.name])" />
              </td>
              <td class="process-errors"><ErrorCell :row="row" /></td>
              </template>
              <td v-else :class="{ 'text-right': column.isNumber }" :data-column="column.name">
                <span class="cell"><SparkCell
                  v-if="row.pid !== null && ['cpu', 'memory'].includes(column.name)"
                  :row="row" :what="column.name" /><span>{{ column.text(row) }}</span></span>
              </td>
            </template>
            <td v-if="!isWide && isSteerable">
              <ActionButtons :fits="fitsOf([row])" :label="row.name"
                             @act="$emit('act', $event, [row.name])" />
            </td>
          </template>
          <template v-else>
            <td></td><td></td>
            <td data-column="name"><bdi class="process-name" dir="auto">{{ row.name }}</bdi></td>
            <td :colspan="columns.length - (isSteerable ? 1 : 2)"></td>
          </template>
        </tr>
        <tr v-if="!isWide && errorOf(row)" class="process-error-row"
            :class="{ chosen: selected.has(row.name) }" :data-error-of="row.name">
          <td></td>
          <td :colspan="columns.length + 1" class="process-error-below"><ErrorCell
               v-if="isNear(row.name)" :row="row" /></td>
        </tr>
        </template>
      </tbody>
    </q-markup-table>`,
};

export const ProcessCards = {
  components: PARTS,
  directives: { near: vNear },
  props: PROPS,
  emits: ["pick", "open", "act", "focus"],
  setup(props) {
    const facts = (row) =>
      props.columns
        .filter((one) => one.text && !["cpu", "memory"].includes(one.name) && one.text(row) !== "")
        .map((one) => `${one.label.toLowerCase()} ${one.text(row)}`)
        .join(" · ");
    const text = (row, name) => props.columns.find((one) => one.name === name).text(row);
    return { facts, text, fitsOf, ...useNearRows(props.rows) };
  },
  template: `
    <ul class="process-cards" aria-label="Processes">
      <li v-for="row in rows" :key="row.name" class="card" :data-process="row.name"
          v-near="observer" :data-state="row.state" :tabindex="row.name === cursor ? 0 : -1"
          :class="{ chosen: selected.has(row.name) }"
          :style="heightOf(row.name)"
          @focus="$emit('focus', row.name)">
        <template v-if="isNear(row.name)">
          <div class="process-card-head">
            <input type="checkbox" :checked="selected.has(row.name)"
                   :aria-label="'Select ' + row.name"
                   @click="$emit('pick', row.name, $event.shiftKey)">
            <button type="button" class="process-name" @click="$emit('open', row.name)">
              <bdi dir="auto">{{ row.name }}</bdi>
            </button>
            <StateCell :row="row" />
          </div>
          <div v-if="facts(row)" class="muted">{{ facts(row) }}</div>
          <div v-if="text(row, 'memory')" class="process-card-lines">
            <span v-for="what in ['cpu', 'memory']" class="cell" :data-column="what">
              <SparkCell :row="row" :what="what" /><span>{{ text(row, what) }}</span>
            </span>
          </div>
          <ErrorCell :row="row" />
          <ActionButtons :fits="fitsOf([row])" :label="row.name"
                         @act="$emit('act', $event, [row.name])" />
        </template>
        <bdi v-else class="process-name process-far" dir="auto">{{ row.name }}</bdi>
      </li>
    </ul>`,
};
