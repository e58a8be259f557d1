// The state of the panel log: the filtered lines, following, the marked line, and jumps.

import { computed, nextTick, onMounted, onUnmounted, ref, shallowRef, watch } from "vue";
import { chosen, log, wall } from "page/store.js";
import { LogFilter, isError, lowerBound } from "page/log/filter.js";
import { bounds, criteria, readAddress, writeAddress } from "page/log/criteria.js";
import { fetchOlder } from "page/log/older_lines.js";
import { prepareSearch, problemOf } from "page/log/regex_search.js";

const TYPING_MS = 120;
let seenMoment = null; // the last moment of the timeline that was shown here

export function useLogView(list) {
  const rows = shallowRef([]);
  const version = ref(0);
  const counts = shallowRef(new Map());
  const problem = ref("");
  const isFollowing = ref(true);
  const pausedAt = ref(0); // the number of the last line when it was paused
  const current = shallowRef(null); // the marked row
  let frame = 0;
  let drawing = 0;
  let typing = 0;
  let wanted = null; // a test of the line to go to, while older lines are fetched

  const draw = () => {
    drawing = 0;
    rows.value = filter.rows;
    version.value++;
  };
  // Answers of the search in a worker come in many pieces: they are drawn once per frame.
  const changed = (isUrgent) => {
    if (isUrgent) draw();
    else drawing ||= requestAnimationFrame(draw);
  };
  const filter = new LogFilter(log, changed, (text) => (problem.value = text));

  const apply = () => {
    const wrong = criteria.isRegex ? problemOf(criteria.text) : "";
    problem.value = wrong ? `Not a regular expression: ${wrong}` : "";
    const names = new Set(chosen.processes);
    filter.set({ ...criteria, names, ...bounds(wall.value), isWrong: wrong !== "" });
    counts.value = filter.counts;
    writeAddress();
  };
  const update = () => {
    frame = 0;
    filter.update();
    if (wanted) jumpAgain();
  };
  const schedule = () => {
    if (!frame) frame = document.hidden ? setTimeout(update, 500) : requestAnimationFrame(update);
  };
  const tick = () => {
    counts.value = new Map(filter.counts);
    if (/^\d+$/.test(criteria.range) && filter.expire(wall.value - Number(criteria.range))) draw();
    fetchOlder();
  };

  const follow = (isOn) => {
    if (isOn) wanted = null;
    if (isFollowing.value && !isOn) pausedAt.value = log.last ?? 0;
    isFollowing.value = isOn;
  };
  const newLines = computed(() => {
    void version.value;
    if (isFollowing.value) return 0;
    return rows.value.length - lowerBound(rows.value, pausedAt.value + 1);
  });
  const mark = async (row) => {
    follow(false);
    current.value = row;
    await nextTick();
    list.value?.reveal(row.number);
  };
  // Go to the first line for which this is true; later once more, if older lines are to come.
  const jumpTo = (isThere) => {
    const row = rows.value.find(isThere) ?? rows.value.at(-1);
    if (row) mark(row);
    wanted = log.first > 1 && isThere(log.rows[0]) ? isThere : null;
  };
  const jumpAgain = () => {
    if (!log.rows.length || (log.first > 1 && wanted(log.rows[0]))) return;
    if (!isFollowing.value) jumpTo(wanted);
    wanted = null;
  };
  const jumpToTime = (time) => jumpTo((row) => row.time >= time);
  // `step`: 1 for the next error, -1 for the one before, 0 for the first.
  const jumpToError = (step) => {
    const all = rows.value;
    const isHere = current.value && !isFollowing.value;
    let index = isHere ? lowerBound(all, current.value.number) : (list.value?.firstIndex() ?? 0);
    if (isFollowing.value) index = all.length;
    if (step === 0) [index, step] = [0, 1];
    else if (isHere || step < 0) index += step;
    while (index >= 0 && index < all.length && !isError(all[index])) index += step;
    if (all[index]) mark(all[index]);
    return Boolean(all[index]);
  };

  const readHash = () => {
    const { number, at } = readAddress();
    apply();
    if (at !== null) [seenMoment, chosen.moment] = [at, at];
    if (at !== null) jumpToTime(at);
    if (number !== null) jumpTo((row) => row.number >= number);
  };
  const visitMoment = () => {
    if (chosen.moment === null || chosen.moment === seenMoment) return;
    seenMoment = chosen.moment;
    jumpToTime(chosen.moment);
  };

  watch(log.version, schedule);
  watch(wall, tick);
  watch(() => chosen.moment, visitMoment);
  watch(
    () => [JSON.stringify(criteria), [...chosen.processes].join("\n")],
    () => {
      clearTimeout(typing);
      typing = setTimeout(apply, TYPING_MS);
    },
  );
  onMounted(() => {
    prepareSearch();
    readHash();
    visitMoment();
    fetchOlder();
    window.addEventListener("hashchange", readHash);
  });
  onUnmounted(() => {
    window.removeEventListener("hashchange", readHash);
    clearTimeout(typing);
    cancelAnimationFrame(frame);
    cancelAnimationFrame(drawing);
    clearTimeout(frame);
    filter.end();
  });
  return {
    rows, version, counts, problem, isFollowing, follow, newLines, current, mark, jumpToError,
    isBusy: () => Boolean(filter.search?.isBusy),
  };
}
