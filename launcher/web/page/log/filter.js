// The lines that match the filter: all are tested once, then only those that come in.

import { RegexSearch } from "page/log/regex_search.js";
import { plain } from "page/shared/sgr.js";

export const LEVELS = ["DEBUG", "INFO", "WARN", "ERROR", "FATAL"];
export const LAUNCHER = "launch"; // the name of lines of the launcher itself
export const SKIPPED = "skipped";
const RANK = new Map(LEVELS.map((level, index) => [level, index]));

export const nameOf = (row) => row.process ?? LAUNCHER;
export const isError = (row) => (RANK.get(row.level) ?? 0) >= 3;

// The index of the first row whose number is not below the value.
export function lowerBound(rows, value) {
  let [low, high] = [0, rows.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (rows[middle].number < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

// A test of one row without its regular expression.
function testOf({ names, level, text, isRegex, isExact, from, to }) {
  const least = RANK.get(level) ?? 0;
  const wanted = isRegex ? "" : isExact ? text : text.toLowerCase();
  return (row) => {
    if (row.time !== null && (row.time < from || row.time > to)) return false;
    if (row.stream === SKIPPED) return true;
    if (names.size && !names.has(nameOf(row))) return false;
    if (least && (RANK.get(row.level) ?? 1) < least) return false;
    if (!wanted) return true;
    const found = plain(row.text);
    return (isExact ? found : found.toLowerCase()).includes(wanted);
  };
}

// `rows`: what is shown. `changed(isUrgent)` is called when it is another or longer; `failed(text)`
// when the regular expression was given up. `log` is a LogBuffer.
export class LogFilter {
  constructor(log, changed, failed) {
    this.log = log;
    this.changed = changed;
    this.failed = failed;
    this.rows = [];
    this.counts = new Map();
    this.search = null;
    this.hasFailed = false;
    this.forget();
  }

  forget() {
    this.generation = this.log.generation;
    this.first = null;
    this.last = null;
    this.counts = new Map();
    this.rows = [];
  }

  // Show other lines: {names: Set, level, text, isRegex, isExact, from, to,
  // isWrong}; `isWrong`: the expression is not valid, and no line is shown.
  set(criteria) {
    this.end();
    this.hasFailed = criteria.isWrong;
    this.test = testOf(criteria);
    if (criteria.isRegex && criteria.text && !criteria.isWrong) {
      this.search = new RegexSearch(
        criteria.text,
        criteria.isExact ? "" : "i",
        (rows, isOlder) => this.show(rows, isOlder, false),
        (text) => ((this.hasFailed = true), (this.search = null), this.failed(text)),
      );
    }
    this.forget();
    this.update();
    this.changed(true);
  }

  end() {
    this.search?.end();
    this.search = null;
  }

  // Take in what has changed in the buffer since the last time.
  update() {
    const all = this.log.rows;
    if (this.generation !== this.log.generation) {
      this.forget();
      this.changed(true);
    }
    if (!all.length) return;
    const [first, last] = [this.log.first, this.log.last];
    if (this.first === null) {
      this.take(all, false);
    } else {
      if (first > this.first) this.cut(first);
      else if (first < this.first) this.take(all.slice(0, lowerBound(all, this.first)), true);
      if (last > this.last) this.take(all.slice(lowerBound(all, this.last + 1)), false);
    }
    [this.first, this.last] = [first, last];
  }

  take(rows, isOlder) {
    for (const row of rows) {
      if (row.stream === SKIPPED) continue;
      const name = nameOf(row);
      this.counts.set(name, (this.counts.get(name) ?? 0) + 1);
    }
    const found = rows.filter(this.test);
    if (this.search) this.search.search(found, isOlder);
    else if (!this.hasFailed) this.show(found, isOlder);
  }

  show(found, isOlder, isUrgent = true) {
    if (!found.length) return;
    if (isOlder) this.rows = [...found, ...this.rows];
    else for (const row of found) this.rows.push(row);
    this.changed(isUrgent);
  }

  // Lines before this number are no longer kept.
  cut(number) {
    this.rows = this.rows.slice(lowerBound(this.rows, number));
    this.counts = new Map();
    for (const row of this.log.rows) {
      if (row.number > this.last) break;
      if (row.stream !== SKIPPED) {
        this.counts.set(nameOf(row), (this.counts.get(nameOf(row)) ?? 0) + 1);
      }
    }
    this.changed(true);
  }

  // Lines before this time have left a range that moves with the clock.
  expire(time) {
    const index = this.rows.findIndex((row) => row.time >= time);
    if (index > 0) this.rows = this.rows.slice(index);
    return index > 0;
  }
}
