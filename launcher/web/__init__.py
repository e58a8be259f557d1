"""The page in the browser (docs/guides/browser.md): a process, client of a run and of the probe.

May import the core and `ros`. It does not import rclpy: what is known of the ROS graph comes from
the probe, its child once a page is open.

Doors: `web_server`, which `--web` and the verb `web` of the console start; `verb`, the same from
another shell; `page_options`, the values of their options; `page_plan_tree`, a process that
evaluates the launch file again for its tree.

* `web_server` listens until the run ends, `site` answers, `access` decides who gets an answer: a
  token in the link, then a cookie.
* `hub` sends messages to all pages, encoded once; a page that reads slowly delays nobody.
  `page_session` sends one page what is queued, and answers its requests.
* `run_feed` follows the run, by `run_client`, and keeps its last lines; `fault_feed`, its faults.
  Both send what comes in quick succession as a `batch`.
  `graph_feed` follows the probe, by `page_probe`: `graph_state` is the graph as pages see it,
  `layout` where it is drawn.
* `remote/` is for other programs: an MCP server, and the same as OpenAPI.
* `metrics` is what the feeds know, for Prometheus (docs/guides/metrics.md).
* `assets` finds our files in `page/` and those of libraries; `page_bundle` joins the modules into
  one script when the server starts; `frozen` makes one HTML file of the page that opens from disk.

`page/` is what the browser gets: `app` is the frame, `feed` the connection, `store` what is known,
one folder per panel (`panel` is its beginning), `shared/` and `styles/page.css` what they have in
common.

Why Vue, Quasar and ECharts, from the wheel of NiceGUI: the browser draws everything from messages;
the wheel has these files for use without a network, so nothing is copied into this repository and
there is no build step. Components of NiceGUI in Python would be objects of the server for each open
page, and an update a message for each: with 100 processes and 100,000 lines that costs the machine
which runs the robots, and a report could not open from disk. Streamlit, Dash and Panel send a
figure for each change. Graphviz as WebAssembly lays out the graph (Python 3.11; before, ECharts).

Messages
--------
A WebSocket at `/feed`, with the cookie and the Origin of the page; one JSON object in each
message. The first request is `open`, within 10 s, and at most 100 connections wait for it. The
server closes with 4403 without the key, 4429 if 100 pages are open, 1011 after an error. Times
(`wall`, `time`) are seconds since 1970. `event` from the server:

* `hello`: `protocol` (1), `server` (differs after a restart), `run` (as the first line of the
  control socket), `launcher`, `wall`, `read_only`, `frozen` (null, or `made` and `report` of a
  file), `ended` (null, or that event), `graph` (`available`, `reason`). After it come the
  processes, which are the first picture, and then the rest.
* `processes`, once a second: `wall`, `processes`: rows of `ps`, with `lines_per_s` and
  `last_error` (`time`, `text`, `number`).
* `history`: `wall`: times; `processes`: for each name the lists `cpu`, `memory`, `lines`.
* `run_events`: `items`: entries of the event log, each with `text`, the event in words (an item
  `other`: events lost on the way to the server); `reset`: they replace what was sent.
* `lines`: `first`: number of the first line; `lines`: lists of process, stream, time, level,
  text. The stream `skipped` stands for lines that were left out.
* `graph`, as of the probe; nodes with `state` (`running`, `ghost`, `gone`), `process`, `since`;
  `positions` of `nodes` and `topics` in points.
* `probe`: `available`, `reason`: the probe has ended, or another one was started; until its first
  graph the last one stays.
* `topics`, once a second while subscribed: `topics`: for each name `rate_hz`, `bytes_per_s`,
  `age_s`, `count`, `state`, `error`.
* `message`, of a subscribed echo: `topic`, `wall`, `sent`, `data`, `skipped`; with `data` null
  `error` if it cannot be read, or `bytes` if it is too long.
* `points`, of a subscribed plot: `topic`, `field`, `points` (time, value; null: a gap), `reset`.
* `plan`, as `plan --json`, with the `name` of each process, and `tree`.
* `expectations`, of a smoke run: `title`, `state` (`open`, `passed`, `failed`), `wall`, `detail`.
* `faults`, of a watched run: `items`: faults (docs/reference/faults.md); `gone`: names of those
  that are none any more; `reset`: they replace what was sent.
* `ended`: `wall`, `how` (`ended`, or `lost` if the launcher was killed), `text`.
* `alive`, every 2 s: `silent_s`, since the last message of the launcher.
* `slow`: `text`: how many lines were left out, since this page reads too slowly.

`do` to the server; each has an `id` and gets `{"id", "ok", "result", "text"}` or `{"id", "ok":
false, "error": {"code", "message", "hint"}}` (with `--web-read-only` the code is `read-only`):

* `open`: `key` (in the page's HTML, if the link has the token), `after` (number of the last line,
  or null), `server`: asks for everything so far.
* `run`: `verb`, `names`, `options`: a request to the control socket.
* `older`: `before`, `count`: lines before a number.
* `tree`: asks for the tree in `plan`.
* `topics`, `echo`, `plot`: `on`, `topic`, `field`: begins or ends what is measured while a page
  shows it.
* `probe`: `request`: `explain`, `get_parameters`, `describe_parameters`, `form`,
  `set_parameters`, `call`, `publish` (at most 100,000 `times`; it ends with the page).
* `cancel`: `of`: the id of an open `publish` of this page; the result has `cancelled`.
"""
