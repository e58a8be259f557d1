// What ROS and the launcher write before a line, and columns of the page say as well:
// [INFO] [1700000000.123456789] [monitor]: The node stays if it is not called like the process.

const LEVEL = "\\[(?:DEBUG|INFO|WARN|ERROR|FATAL)\\]";
const PREFIX = new RegExp(`^((?:\\x1b\\[[\\d;]*m)*)${LEVEL} (?:\\[\\d+\\.\\d+\\] )?\\[([^\\]]*)\\]: `);

export function withoutPrefix(text, process) {
  return text.replace(PREFIX, (_, escapes, node) =>
    (process ?? "").replace(/-\d+$/, "") === node ? escapes : `${escapes}[${node}] `,
  );
}
