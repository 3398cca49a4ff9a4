// SPDX-License-Identifier: Apache-2.0
// Names of files and the like come into the page by these functions only: as text.

export const byId = (id) => document.getElementById(id);

/** An element with attributes and children; a child that is a string becomes text. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** A small field of a color, sRGB bytes. */
export function swatch(rgb, tag = 'i') {
  const made = document.createElement(tag);
  made.style.background = `rgb(${rgb.map(Math.round)})`;
  return made;
}

export function setPressed(button, isPressed) { button.setAttribute('aria-pressed', String(isPressed)); }

/** Offers bytes or a Blob as a file to save. */
export function save(content, name, type) {
  const url = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], {type}));
  const link = element('a', {href: url, download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** "1,234,567" */
export const whole = (number) => Math.round(number).toLocaleString('en-US');

/** A length in meters for people: "12.3 cm". */
export function length(meters) {
  if (meters >= 1) return `${meters.toFixed(2)} m`;
  return meters >= 0.01 ? `${(100 * meters).toFixed(1)} cm` : `${(1000 * meters).toFixed(1)} mm`;
}
