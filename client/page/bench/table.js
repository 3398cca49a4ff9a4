// SPDX-License-Identifier: Apache-2.0
// Tables. A cell shows its value as text, and has all its digits in `data-value`.
import {element} from '../src/dom.js';
import {text} from './figures.js';

/**
 * A table that scrolls sideways where the window is narrow. `columns` is [{title, of: (row) => value, format}]; `name` is
 * that of the table for those who read it by a program. A column with `isText` is aligned to the left.
 */
export function table(name, caption, columns, rows) {
  const head = element('tr', {}, ...columns.map(({title, isText}) => element('th', {scope: 'col', class: isText ? 'text' : ''}, title)));
  const body = element('tbody', {});
  for (const row of rows) {
    body.append(element('tr', {}, ...columns.map(({of, format = text, isText}) => cell(of(row), format(of(row), row), isText))));
  }
  const made = element('table', {id: `table-${name}`}, element('caption', {}, caption), element('thead', {}, head), body);
  return element('div', {class: 'scroll', tabindex: '0', role: 'region', 'aria-label': caption}, made);
}

function cell(value, shown, isText) {
  const made = element('td', {class: isText ? 'text' : ''}, shown);
  if (typeof value === 'number') made.dataset.value = String(value);
  return made;
}

/** A column of numbers, of texts. */
export const numbers = (title, of, format) => ({title, of: typeof of === 'string' ? (row) => row[of] : of, format});
export const texts = (title, of) => ({...numbers(title, of), isText: true});

/** A table with two columns: names and values. `entries` is [[name, value, format]]. */
export function facts(name, caption, entries) {
  return table(name, caption, [texts('', ([key]) => key), {title: '', of: ([, value]) => value, format: (value, [, , format = text]) => format(value)}],
               entries.filter(([, value]) => value !== undefined));
}

/** The same, closed until it is asked for: the figures of a chart. */
export function figuresOf(...parameters) {
  return element('details', {}, element('summary', {}, 'Figures'), table(...parameters));
}
