// Light and dark: the system's setting until somebody chooses.

import { remember, remembered } from "page/shared/remembered.js";

export function useTheme() {
  window.Quasar.Dark.set(remembered("is-dark", "auto"));
}

export function toggleTheme() {
  window.Quasar.Dark.toggle();
  remember("is-dark", window.Quasar.Dark.isActive);
}
