// The shown lines as a text file.

import { hello } from "page/store.js";
import { nameOf } from "page/log/filter.js";
import { plain } from "page/shared/sgr.js";

function textOf(row) {
  const time = row.time === null ? "" : new Date(row.time * 1000).toISOString();
  return `${time} ${nameOf(row)}: ${plain(row.text)}\n`;
}

export function download(rows) {
  const pieces = [];
  for (let i = 0; i < rows.length; i += 5000) {
    pieces.push(rows.slice(i, i + 5000).map(textOf).join(""));
  }
  const url = URL.createObjectURL(new Blob(pieces, { type: "text/plain;charset=utf-8" }));
  const anchor = document.createElement("a");
  anchor.href = url;
  anchor.download = `${hello.value?.run.id ?? "run"}.log.txt`;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
