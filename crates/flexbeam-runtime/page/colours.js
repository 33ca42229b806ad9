// Colours of the signals and of the paper that plots are drawn on.
// Enters: the theme of the page (its custom properties). Leaves: colours as CSS text.
// A signal has the same colour in every plot; told apart also by people who see colours otherwise.

/** Key -> [dark, light]. */
const SIGNALS = {
  reference_rad: ["#8e9aa6", "#7b858e"],
  smoothed_rad: ["#b9a3e3", "#7d5fc0"],
  psi_rad: ["#5eb1ef", "#1f6fb2"],
  y_model_rad: ["#e2a93b", "#b07400"],
  theta_rad: ["#56c2c2", "#12807f"],
  alpha_rad: ["#ef8b5b", "#c4541a"],
  error_rad: ["#e07bb0", "#b03a78"],
  voltage_v: ["#7fd06a", "#3c8a26"],
  commanded_v: ["#c8d05e", "#7c8410"],
  u_v: ["#9aa8ff", "#4b57c9"],
  lateness_ns: ["#b0bec5", "#607d8b"],
  execution_ns: ["#a1887f", "#795548"],
};

/** For signals that have no colour of their own: by their name, so that it is the same every time. */
const OTHERS = [
  ["#d7a6d0", "#8d4c86"],
  ["#8fd3b0", "#2b7d56"],
  ["#e6c28a", "#8a6420"],
  ["#9cc4e4", "#3a6d95"],
];

/** Names of the page's custom properties that plots use. */
const TOKENS = ["paper", "card", "raised", "line", "ink", "soft", "faint", "accent", "good", "warn", "bad", "grid"];

let theme = null;

/** The theme in force, read once and kept until `themeChanged`. */
function current() {
  if (theme) return theme;
  const root = document.documentElement;
  const style = getComputedStyle(root);
  const chosen = root.dataset.theme;
  const dark = chosen === "dark" || (chosen !== "light" && matchMedia("(prefers-color-scheme: dark)").matches);
  theme = { dark };
  for (const name of TOKENS) theme[name] = style.getPropertyValue(`--${name}`).trim();
  return theme;
}

/** To be called after the theme of the page has changed, before plots are refreshed. */
export function themeChanged() {
  theme = null;
}

/**
 * Colour of a signal in the theme in force.
 * @param {string} key as in a recording: `psi_rad`
 * @returns {string} `#rrggbb`
 */
export function colourOf(key) {
  const own = SIGNALS[key] ?? OTHERS[[...key].reduce((sum, c) => sum + c.charCodeAt(0), 0) % OTHERS.length];
  return own[current().dark ? 0 : 1];
}

/** True for signals that are wanted, not measured: drawn dashed. */
export function dashed(key) {
  return key === "reference_rad";
}

/**
 * Colours of the paper: `ink`, `soft`, `faint`, `grid`, `card`, ...
 * @returns {Record<string, string>}
 */
export function paper() {
  return current();
}
