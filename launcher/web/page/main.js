// Starts the page: loads Quasar, which needs a global Vue, and mounts the application.

import * as Vue from "vue";
import { start } from "page/feed.js";
import { useTheme } from "page/theme.js";

const FIRST_MS = 300; // for the first data, before a picture without any is drawn

const first = start();
window.Vue = Vue;

function script(url) {
  return new Promise((resolve, reject) => {
    const element = document.createElement("script");
    element.src = url;
    element.onload = resolve;
    element.onerror = () => reject(new Error(`cannot load ${url}`));
    document.head.append(element);
  });
}

await script(window.frozenFiles?.["/lib/quasar.js"] ?? "/lib/quasar.js");
const { App } = await import("page/app.js");
const app = Vue.createApp(App);
app.use(window.Quasar, { config: { dark: "auto" } });
app.config.errorHandler = (error) => {
  console.error(error);
};
useTheme();
await Promise.race([first, new Promise((resolve) => setTimeout(resolve, FIRST_MS))]);
app.mount("#app");
