// Starts the page: loads Quasar, which needs a global Vue, and mounts the application.

import * as Vue from "vue";
import { useTheme } from "page/theme.js";

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
app.mount("#app");
