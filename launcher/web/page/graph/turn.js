// The arrangement goes from left to right. Where the area is too narrow for that, the picture is
// turned: from top to bottom, with the same neighbours.

const MOST = 150; // items; more are wide when they are turned
const GAP = 16;
const LAYER = 0.42; // of the distance between two layers

// Places from top to bottom, as close as the boxes allow.
export function turned(items, places) {
  const boxes = items.filter((item) => places.has(item.id));
  const at = (item) => places.get(item.id);
  let spread = 0;
  boxes.forEach((one, index) => {
    for (const other of boxes.slice(index + 1)) {
      const [dx, dy] = [at(one)[0] - at(other)[0], at(one)[1] - at(other)[1]].map(Math.abs);
      if (dx * LAYER > (one.height + other.height) / 2 + GAP || dy < 1) continue;
      spread = Math.max(spread, ((one.width + other.width) / 2 + GAP) / dy);
    }
  });
  return new Map([...places].map(([id, [x, y]]) => [id, [y * (spread || 1), x * LAYER]]));
}

// The zoom at which all boxes are in an area of this size.
export function zoomOf(items, places, width, height) {
  const extent = (axis, size) => {
    let [low, high] = [Infinity, -Infinity];
    for (const item of items) {
      const at = places.get(item.id)?.[axis];
      if (at === undefined) continue;
      low = Math.min(low, at - item[size] / 2);
      high = Math.max(high, at + item[size] / 2);
    }
    return Math.max(1, high - low);
  };
  return Math.min(width / extent(0, "width"), height / extent(1, "height"));
}

// Whether the boxes can be larger if the picture is turned.
export function isBetterTurned(items, places, { clientWidth: width, clientHeight: height }) {
  if (!places.size || places.size > MOST || zoomOf(items, places, width, height) > 0.95) {
    return false;
  }
  const other = zoomOf(items, turned(items, places), width, height);
  return other > zoomOf(items, places, width, height) * 1.15;
}
