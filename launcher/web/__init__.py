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
* `run_feed` follows the run, by `run_client`, and keeps its last lines. `graph_feed` follows the
  probe, by `page_probe`: `graph_state` is the graph as pages see it, `layout` where it is drawn.
* `metrics` is what the feeds know, for Prometheus (docs/guides/metrics.md).
* `assets` finds our files in `page/` and those of libraries; `frozen` makes one HTML file of the
  page that opens from disk.

`page/` is what the browser gets: `app` is the frame, `feed` the connection, `store` what is known,
one folder per panel (`panel` is its beginning), `shared/` and `styles/page.css` what they have in
common.
"""
