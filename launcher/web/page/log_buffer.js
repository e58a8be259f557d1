// The last lines of the run, in order of their numbers.

import { ref } from "vue";

export const KEEP_LINES = 100_000;

// A row: {number, process, stream, time, level, text}. `version` changes with the lines,
// `generation` when the numbers begin anew.
export class LogBuffer {
  constructor() {
    this.rows = [];
    this.version = ref(0);
    this.generation = 0;
  }

  get first() {
    return this.rows.length ? this.rows[0].number : null;
  }

  get last() {
    return this.rows.length ? this.rows[this.rows.length - 1].number : null;
  }

  clear() {
    this.rows = [];
    this.generation++;
    this.version.value++;
  }

  // Add lines that follow, or older ones that come before. What is here already is left out.
  add(first, lines) {
    const rows = lines.map(([process, stream, time, level, text], index) =>
      Object.freeze({ number: first + index, process, stream, time, level, text }),
    );
    if (!this.rows.length) {
      this.rows = rows;
    } else if (first < this.first) {
      const older = rows.filter((row) => row.number < this.first);
      const room = Math.max(0, KEEP_LINES - this.rows.length);
      this.rows = [...older.slice(older.length - Math.min(room, older.length)), ...this.rows];
    } else {
      const last = this.last;
      for (const row of rows) if (row.number > last) this.rows.push(row);
      // Cut in steps: removing the first of 100,000 rows each time would be slow.
      if (this.rows.length > KEEP_LINES * 1.05) this.rows = this.rows.slice(-KEEP_LINES);
    }
    this.version.value++;
  }
}
