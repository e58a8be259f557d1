// The faults of a watched run, in the order and with the words of `launcher faults`.

const ORDER = ["active", "suspected", "healed"];

// Active and not muted.
export const isReported = (fault) => fault.state === "active" && !fault.muted;

// {word, tone, icon} of a state; of an active fault also muted or acknowledged.
export function stateOf(fault) {
  if (fault.state === "healed") return { word: "healed", tone: "good", icon: "check_circle" };
  if (fault.state === "suspected") return { word: "suspected", tone: "warn", icon: "help" };
  if (fault.muted) return { word: "muted", tone: "muted", icon: "notifications_off" };
  if (fault.acknowledged) return { word: "acknowledged", tone: "warn", icon: "person" };
  return { word: "active", tone: "bad", icon: "error" };
}

function compared(a, b) {
  const byState = ORDER.indexOf(a.state) - ORDER.indexOf(b.state);
  if (byState) return byState;
  return (a.first_s - b.first_s) * (a.state === "healed" ? -1 : 1);
}

// [{depth, fault}]: active ones first, and each behind the one that it follows from.
export function arranged(faults) {
  const known = new Set(faults.map((one) => one.fault));
  const behind = new Map();
  for (const one of faults) {
    const root = known.has(one.follows) ? one.follows : null;
    behind.set(root, [...(behind.get(root) ?? []), one]);
  }
  const found = new Map();
  const add = (those, depth) => {
    for (const fault of [...those].sort(compared)) {
      if (found.has(fault.fault)) continue;
      found.set(fault.fault, { depth, fault });
      add(behind.get(fault.fault) ?? [], depth + 1);
    }
  };
  add(behind.get(null) ?? [], 0);
  add(faults, 0); // those that follow from each other
  return [...found.values()];
}
