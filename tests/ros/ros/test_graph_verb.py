"""`graph` against real nodes, and its page in a real browser."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator

import pytest

from tests.support.browser import browser
from tests.support.drawing import CAN_DRAW, HOW_TO_DRAW
from tests.support.node_process import line_of
from tests.support.verbs import TIMEOUT_S, launcher

TREE = """/site/east/listener
├─ <- /chatter [std_msgs/msg/String] <- /talker
└─ <- /weak [std_msgs/msg/String] <- /talker (nothing arrives: RELIABILITY)
/talker
├─ -> /chatter [std_msgs/msg/String] -> /site/east/listener
└─ -> /weak [std_msgs/msg/String] -> /site/east/listener (nothing arrives: RELIABILITY)
/twin  (2 nodes of this name)
4 nodes, 2 topics, 1 connection on which nothing arrives
"""

# Runs in the page after its own script; what it finds ends up in the document.
PROBE = """
<script>
const texts = [...document.querySelectorAll("g.node")].map((node) => {
  const shape = node.querySelector("ellipse, polygon").getBoundingClientRect();
  const inside = [...node.querySelectorAll("text")].every((text) => {
    const box = text.getBoundingClientRect();
    return box.width > 0 && box.left >= shape.left && box.right <= shape.right;
  });
  return [node.querySelector("title").textContent, inside];
});
const fitted = svg.getAttribute("viewBox");
view.dispatchEvent(new WheelEvent("wheel", { deltaY: -300, clientX: 9, clientY: 9 }));
const zoomed = svg.getAttribute("viewBox");
view.dispatchEvent(new PointerEvent("pointerdown", { clientX: 10, clientY: 10 }));
window.dispatchEvent(new PointerEvent("pointermove", { clientX: 60, clientY: 30 }));
window.dispatchEvent(new PointerEvent("pointerup", {}));
const moved = svg.getAttribute("viewBox");
view.dispatchEvent(new MouseEvent("dblclick", {}));
const again = svg.getAttribute("viewBox");
document.querySelector("g.node ellipse").dispatchEvent(new MouseEvent("click", { bubbles: true }));
const findings = {
  texts, fitted, zoomed, moved, again,
  width: svg.getBoundingClientRect().width,
  red: [...document.querySelectorAll("g.edge path")]
    .filter((path) => getComputedStyle(path).stroke === "rgb(197, 48, 48)").length,
  ellipses: document.querySelectorAll("g.node ellipse").length,
  boxes: document.querySelectorAll("g.node polygon").length,
  clusters: document.querySelectorAll("g.cluster").length,
  dimmed: document.querySelectorAll(".dim").length,
  resources: performance.getEntriesByType("resource").length,
};
const out = document.createElement("pre");
out.id = "findings";
out.textContent = JSON.stringify(findings);
document.body.append(out);
</script>
"""


def test_the_tree_shows_connections_and_the_mismatch(verb):
    answer = verb("graph", "--mode", "active")
    assert (answer.out, answer.err, answer.code) == (TREE, "", 0)


def test_the_tree_is_drawn_with_ascii_where_the_output_has_nothing_else(env):
    words = ("graph", "--mode", "active", "--spin-time", "60")
    answer = launcher({**env, "PYTHONIOENCODING": "ascii"}, *words)
    plain = TREE.replace("├─", "|-").replace("└─", "`-")
    assert (answer.out, answer.err, answer.code) == (plain, "", 0)


def test_a_saved_graph_is_compared_and_the_exit_code_tells(verb, tmp_path):
    path = tmp_path / "graph.json"
    path.write_text(verb("graph", "--json").out, encoding="utf-8")
    same = verb("graph", "--diff", str(path))
    assert (same.out, same.code) == ("", 0)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["nodes"].remove("/talker")
    path.write_text(json.dumps(document), encoding="utf-8")
    other = verb("graph", "--diff", str(path))
    assert (other.out, other.code) == ("+ node /talker\n", 1)


def test_an_empty_graph_explains_itself(empty_domain):
    answer = launcher(empty_domain, "graph")
    assert answer.out == "0 nodes, 0 topics\n"
    assert answer.err.startswith("0 nodes on domain")


@pytest.mark.parametrize("option", ["--dot", "--mermaid"])
def test_sources_of_drawings_name_the_mismatch(verb, option):
    assert "nothing arrives: RELIABILITY" in verb("graph", option).out


def test_watch_prints_what_comes_and_goes(env):
    watch = subprocess.Popen(
        [sys.executable, "-m", "launcher", "graph", "--watch", "--hidden", "--period", "0.05"],
        env=env,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert watch.stdout is not None
    while line_of(watch.stdout).strip():
        pass  # the tree, which an empty line ends
    # It stays until it has been seen: discovery may take longer than a short publication.
    words = ["topic", "pub", "/news", "std_msgs/String", "--rate", "5", "-w", "0"]
    publisher = subprocess.Popen(
        [sys.executable, "-m", "launcher", *words], env=env, stdout=subprocess.DEVNULL
    )
    fact = "publishes /news [std_msgs/msg/String] RELIABLE VOLATILE AUTOMATIC"
    changes = _only(iter(watch.stdout.readline, ""), fact)
    signs = [next(changes).split()[1]]
    publisher.terminate()
    signs.append(next(changes).split()[1])
    publisher.wait(TIMEOUT_S)
    watch.terminate()
    watch.communicate(timeout=TIMEOUT_S)
    assert (signs, watch.returncode) == (["+", "-"], 0)


def _only(lines: Iterator[str], fact: str) -> Iterator[str]:
    return (line for line in lines if fact in line)


def draws(answer) -> bool:
    """Whether there is a drawing; where Graphviz cannot be, that it is said how to get it."""
    if not CAN_DRAW:
        assert HOW_TO_DRAW in answer.err
        return False
    assert answer.code == 0, answer
    return True


@pytest.mark.browser
def test_the_page_works_in_a_real_browser_and_needs_no_network(verb, tmp_path):
    page = tmp_path / "graph.html"
    if not draws(verb("graph", "--mode", "active", "--html", str(page))):
        return
    page.write_text(page.read_text(encoding="utf-8") + PROBE, encoding="utf-8")
    found = look_at(page, tmp_path)
    assert found["texts"]
    assert all(inside for _, inside in found["texts"]), found["texts"]
    assert (found["ellipses"], found["boxes"], found["clusters"]) == (3, 2, 1)
    assert found["red"] == 1
    assert found["width"] > 500
    views = [
        tuple(map(float, str(found[name]).split()))
        for name in ("fitted", "zoomed", "moved", "again")
    ]
    assert len(set(views)) == 3
    assert views[0] == views[3]
    assert found["dimmed"] > 0
    assert found["resources"] == 0


def look_at(page, profile) -> dict[str, object]:
    command = [browser(), "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"]
    command += ["--disable-dev-shm-usage", f"--user-data-dir={profile / 'profile'}"]
    command += ["--window-size=1400,700", page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S)
    findings = re.search(r'<pre id="findings">(.*?)</pre>', done.stdout, re.DOTALL)
    assert findings is not None, done.stderr
    found: dict[str, object] = json.loads(findings[1].replace("&gt;", ">").replace("&amp;", "&"))
    return found


def test_a_drawing_is_written_to_a_file(verb, tmp_path):
    path = tmp_path / "graph.svg"
    answer = verb("graph", "--svg", str(path))
    if not draws(answer):
        return
    assert answer.err == f"wrote {path}\n"
    assert path.read_text(encoding="utf-8").rstrip().endswith("</svg>")
    missing = verb("graph", "--svg", str(tmp_path / "no" / "graph.svg"))
    assert (missing.code, "No such file" in missing.err) == (1, True)
