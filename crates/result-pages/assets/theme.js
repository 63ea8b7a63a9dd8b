"use strict";
// Light and dark: as the system, until the button chooses.
const theme = (() => {
  const root = document.documentElement;
  const button = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const listeners = [];
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : system.matches);
  const show = () => {
    if (button) {
      button.textContent = isDark() ? "Light" : "Dark";
      button.setAttribute("aria-label", `${button.textContent} colours`);
    }
    for (const listener of listeners) listener();
  };
  if (button) {
    button.addEventListener("click", () => {
      root.dataset.theme = isDark() ? "light" : "dark";
      show();
    });
  }
  system.addEventListener("change", show);
  const colour = (name) => getComputedStyle(root).getPropertyValue(name).trim();
  show();
  return { isDark, colour, onChange: (listener) => listeners.push(listener) };
})();
// A number with six significant digits, or with those that its error leaves.
const digits = (value, n) => {
  if (value === 0) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  if (exponent >= -4 && exponent < 6) return value.toFixed(Math.max(0, n - 1 - exponent));
  return value.toExponential(Math.max(0, n - 1)).replace("e+", "e");
};
const withError = (value, error) => {
  if (error === undefined || error === null) return digits(value, 6);
  if (error === 0) return `${digits(value, 6)} ± 0`;
  const exponent = (x) => Math.floor(Math.log10(Math.abs(x)));
  const n = value === 0 ? 6 : Math.min(6, Math.max(1, exponent(value) - exponent(error) + 2));
  return `${digits(value, n)} ± ${digits(error, 2)}`;
};
const short = (value) => digits(value, 3);
