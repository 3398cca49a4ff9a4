// SPDX-License-Identifier: Apache-2.0
// Numbers as texts for people. What was not measured is a dash.

const NOTHING = '–';
const formatter = (digits) => new Intl.NumberFormat('en-US', {minimumFractionDigits: digits, maximumFractionDigits: digits});
const formatters = Array.from({length: 4}, (_, digits) => formatter(digits));

export const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

/** A function that writes a number with so many digits after the point, and a unit. */
export const fixed = (digits, unit = '') => (value) =>
  isNumber(value) ? `${formatters[digits].format(value)}${unit && ` ${unit}`}` : NOTHING;

export const whole = fixed(0);
export const rate = fixed(1);
export const share = fixed(2, '%');
export const text = (value) => value === null || value === undefined ? NOTHING : String(value);

/** Milliseconds with three significant digits or more: "0.123", "12.3", "1,234". */
export function milliseconds(value) {
  if (!isNumber(value)) return NOTHING;
  const size = Math.abs(value);
  if (size === 0) return '0';
  return formatters[size < 1 ? 3 : size < 10 ? 2 : size < 100 ? 1 : 0].format(value);
}

/** "4.61 MB" */
export function bytes(value) {
  if (!isNumber(value)) return NOTHING;
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  const power = Math.min(units.length - 1, Math.max(0, Math.floor(Math.log10(Math.abs(value) || 1) / 3)));
  return `${formatters[power === 0 ? 0 : 2].format(value / 1000 ** power)} ${units[power]}`;
}

/** The latency of a percentile. One that falls among failed frames has no end. */
export const latency = (value, name, beyond) => beyond?.includes(name) ? '∞' : milliseconds(value);
