// Fetches the lines from before this page was opened, in idle time.

import { request } from "page/feed.js";
import { link, log } from "page/store.js";
import { KEEP_LINES } from "page/log_buffer.js";

const COUNT = 5000;
const PAUSE_MS = 150;
const idle = window.requestIdleCallback ?? ((call) => setTimeout(call, 50));

let isRunning = false;

// Until nothing older is left, or enough is here; may be called again at any time.
export async function fetchOlder() {
  if (isRunning) return;
  isRunning = true;
  try {
    while (log.first > 1 && log.rows.length < KEEP_LINES && link.state === "open") {
      const before = log.first;
      const { result } = await request("older", { before, count: COUNT });
      if (!result.lines.length || log.first !== before) break;
      await new Promise((resolve) => idle(resolve, { timeout: 1000 }));
      log.add(result.first, result.lines);
      await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
    }
  } catch {
    // the connection was lost: the next call goes on
  } finally {
    isRunning = false;
  }
}
