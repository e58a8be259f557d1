// What the log shows: kept while other panels are shown, and in the address, so that links work.

import { reactive, watch } from "vue";
import { chosen, hello } from "page/store.js";
import { LEVELS } from "page/log/filter.js";
import { link, parameters } from "page/shared/address.js";
import { remember, remembered } from "page/shared/remembered.js";

const NARROW = 700; // lines are wrapped below this width, until the reader decides

// `range`: "all", "60" or "300" (the last seconds), or "times" with `from` and `to` ("12:03:04").
export const criteria = reactive({
  level: "",
  text: "",
  isRegex: false,
  isExact: false,
  range: "all",
  from: "",
  to: "",
});
export const look = reactive(
  Object.assign(
    { times: "clock", isWrapped: innerWidth < NARROW, withColours: true, isShort: true },
    remembered("log-look", {}),
  ),
);
watch(look, () => remember("log-look", look));

const DAY_S = 86400;

// Seconds since 1970 of a time of day in the run: the first such time from its start on.
function wallOf(text, fallback) {
  const found = /^(\d\d):(\d\d)(?::(\d\d(?:\.\d+)?))?$/.exec(text);
  if (!found) return fallback;
  const started = hello.value?.run.started_wall_s ?? Date.now() / 1000;
  const day = new Date(started * 1000);
  day.setHours(Number(found[1]), Number(found[2]), 0, 0);
  const wall = day.getTime() / 1000 + Number(found[3] ?? 0);
  return wall < started - 60 ? wall + DAY_S : wall;
}

// {from, to}: seconds since 1970; `now` is the server's time.
export function bounds(now) {
  if (criteria.range === "all") return { from: -Infinity, to: Infinity };
  if (criteria.range === "times") {
    return { from: wallOf(criteria.from, -Infinity), to: wallOf(criteria.to, Infinity) };
  }
  return { from: now - Number(criteria.range), to: Infinity };
}

const isTime = (text) => (/^\d\d:\d\d/.test(text ?? "") ? text : "");

// Take over the parameters of the address: where to go to, {number, at}, which may be null. One
// that has only a time keeps the filters.
export function readAddress() {
  const words = parameters("log");
  const keys = words ? [...words.keys()] : [];
  const at = Number(words?.get("at")) || null;
  const number = Number(words?.get("number")) || null;
  if (keys.some((key) => key !== "at")) readFilters(words);
  return { number, at };
}

function readFilters(words) {
  chosen.processes.clear();
  for (const name of words.getAll("process")) chosen.processes.add(name);
  const level = (words.get("level") ?? "").toUpperCase();
  const [from, to] = [isTime(words.get("from")), isTime(words.get("to"))];
  const last = words.get("last");
  Object.assign(criteria, {
    level: LEVELS.includes(level) ? level : "",
    text: words.get("text") ?? "",
    isRegex: words.get("regex") === "1",
    isExact: words.get("case") === "1",
    range: from || to ? "times" : ["60", "300"].includes(last) ? last : "all",
    from,
    to,
  });
}

// Write what is shown into the address, without another entry in the browser's history.
export function writeAddress() {
  if (!parameters("log")) return;
  const hash = link("log", {
    process: [...chosen.processes],
    level: criteria.level,
    text: criteria.text,
    regex: criteria.text && criteria.isRegex && "1",
    case: criteria.text && criteria.isExact && "1",
    from: criteria.range === "times" && criteria.from,
    to: criteria.range === "times" && criteria.to,
    last: /^\d+$/.test(criteria.range) && criteria.range,
  });
  if (hash !== location.hash) history.replaceState(history.state, "", hash);
}
