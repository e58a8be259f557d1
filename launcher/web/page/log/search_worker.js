// Runs in a worker: which of some texts a regular expression matches. An expression that needs
// very long holds up only the worker, which the page then ends.

let expression = null;
let escapes = null; // what is no part of a text

self.onmessage = ({ data }) => {
  if (data.source !== undefined) {
    expression = new RegExp(data.source, data.flags);
    escapes = new RegExp(data.escapes, "g");
    return;
  }
  const found = [];
  data.texts.forEach((text, index) => {
    const plain = text.includes("\x1b") ? text.replace(escapes, "") : text;
    if (expression.test(plain)) found.push(index);
  });
  self.postMessage(Uint32Array.from(found));
};
