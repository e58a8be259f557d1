// Addresses of panels with their parameters, such as #/log?process=robot_1-3&level=ERROR.

// Values may be lists; what is empty is left out.
export function link(panel, fields = {}) {
  const words = new URLSearchParams();
  for (const [name, value] of Object.entries(fields)) {
    const values = Array.isArray(value) ? value : [value];
    for (const one of values) {
      if (one !== null && one !== undefined && one !== "" && one !== false) words.append(name, one);
    }
  }
  const text = words.toString();
  return `#/${panel}${text ? `?${text}` : ""}`;
}

// The parameters of the address as it is now, for a panel; null if another one is shown.
export function parameters(panel) {
  const [name, query = ""] = location.hash.replace(/^#\/?/, "").split(/\?(.*)/s);
  return name === panel ? new URLSearchParams(query) : null;
}

export const goTo = (panel, fields = {}) => {
  location.hash = link(panel, fields);
  note(location.hash);
};

const last = new Map(); // panel -> its last address, to come back to what it showed

function note(hash) {
  const panel = hash.replace(/^#\/?/, "").split("?")[0];
  if (panel) last.set(panel, hash);
}

// The address of a panel as it was left; what is shown now may have changed its own silently.
export function lastAddress(panel) {
  note(location.hash);
  return last.get(panel) ?? link(panel);
}

window.addEventListener("hashchange", (event) => {
  note(new URL(event.oldURL).hash);
  note(new URL(event.newURL).hash);
});

const query = () => new URLSearchParams(location.hash.split("?")[1] ?? "");

export const hashValue = (key) => query().get(key);
export const hashValues = (key) => query().getAll(key);

// Set the values of the panel that is shown; null or [] removes one. Adds no step to the history.
export function keepInHash(values) {
  const all = query();
  for (const [key, value] of Object.entries(values)) {
    all.delete(key);
    for (const one of [value].flat()) if (one !== null && one !== undefined) all.append(key, one);
  }
  const text = all.toString();
  const panel = location.hash.split("?")[0] || "#/";
  history.replaceState(history.state, "", `${panel}${text ? `?${text}` : ""}`);
  note(location.hash);
}
