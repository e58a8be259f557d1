// Searches rows with a regular expression in a worker, in order, with a limit of time.

import { OTHER_ESCAPES, SGR } from "page/shared/sgr.js";

const WORKER = "/page/log/search_worker.js";
const CHUNK = 4000; // rows of one message to the worker
const LIMIT_MS = 2000; // for one of them

let spare = null; // a worker that has nothing to do: starting one takes longer than a search

function startWorker() {
  return new Worker(window.frozenFiles?.[WORKER] ?? WORKER);
}

// Have a worker ready for the first search.
export function prepareSearch() {
  try {
    spare ??= startWorker();
  } catch {
    // the search itself says so
  }
}

// What is wrong with an expression, or "".
export function problemOf(source) {
  try {
    new RegExp(source);
    return "";
  } catch (error) {
    return error.message.replace(/^Invalid regular expression: /, "");
  }
}

// `found(rows, isOlder)` gets the matching rows of each chunk; `failed(text)` ends the search.
export class RegexSearch {
  constructor(source, flags, found, failed) {
    this.found = found;
    this.failed = failed;
    this.jobs = []; // {rows, isOlder}: sent, not answered
    this.timer = null;
    this.worker = null;
    try {
      this.worker = spare ?? startWorker();
      spare = null;
    } catch {
      queueMicrotask(() => this.fail("This browser cannot search with expressions in this page."));
      return;
    }
    this.worker.onmessage = (event) => this.answered(event.data);
    this.worker.onerror = (event) => this.fail(`The search has failed: ${event.message}`);
    this.worker.postMessage({ source, flags, escapes: `${SGR.source}|${OTHER_ESCAPES.source}` });
  }

  get isBusy() {
    return this.jobs.length > 0;
  }

  // `isOlder`: these rows come before all others.
  search(rows, isOlder) {
    if (!this.worker) return;
    const chunks = [];
    for (let i = 0; i < rows.length; i += CHUNK) chunks.push(rows.slice(i, i + CHUNK));
    if (isOlder) chunks.reverse();
    for (const chunk of chunks) {
      this.jobs.push({ rows: chunk, isOlder });
      this.worker.postMessage({ texts: chunk.map((row) => row.text) });
    }
    if (!this.timer) this.wait();
  }

  wait() {
    clearTimeout(this.timer);
    this.timer = null;
    if (!this.jobs.length) return;
    this.timer = setTimeout(() => {
      const first = this.jobs[0].rows[0].number;
      this.fail(
        `The expression takes too long: the search was stopped after ${LIMIT_MS / 1000} s ` +
          `at line ${first} or behind it. What is shown is not complete.`,
      );
    }, LIMIT_MS);
  }

  answered(indices) {
    const job = this.jobs.shift();
    this.wait();
    this.found(Array.from(indices, (index) => job.rows[index]), job.isOlder);
  }

  fail(text) {
    this.worker?.terminate();
    this.worker = null;
    this.end();
    this.failed(text);
  }

  end() {
    clearTimeout(this.timer);
    if (this.isBusy || spare) this.worker?.terminate();
    else spare = this.worker;
    this.jobs = [];
    this.worker = null;
  }
}
