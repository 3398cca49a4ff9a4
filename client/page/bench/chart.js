// SPDX-License-Identifier: Apache-2.0
// Line charts by uPlot. Their colors are those of the style sheet, so that they follow light, dark and print.
import uPlot from 'uplot';
import {element} from '../src/dom.js';
import {milliseconds} from './figures.js';

const HEIGHT = 260, PRINT_WIDTH = 680;
const FONT = '12px system-ui, "DejaVu Sans", sans-serif';
const charts = [];

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

function axis(label, values, more = {}) {
  return {
    label, labelSize: 18, labelFont: FONT, font: FONT, stroke: () => color('quiet'), grid: {stroke: () => color('edge'), width: 1},
    ticks: {stroke: () => color('edge'), width: 1}, ...(values && {values: (plot, splits) => splits.map((v) => v === null ? '' : values(v))}),
    ...more,
  };
}

/**
 * A line of a chart: `tone` is a color of the style sheet. A line has dashes, so that it is told from others without color.
 * `isStepped`: the value holds until the next one. `hasPoints`: each value has a dot.
 */
export function line(label, tone, format, {dash, isStepped, hasPoints, width = 1.75} = {}) {
  return {
    label, tone: `var(--${tone})`, stroke: () => color(tone), width, dash, value: (plot, value) => value === null ? '' : format(value), spanGaps: false,
    points: hasPoints ? {show: true, size: 7, fill: () => color(tone)} : {show: false},
    ...(isStepped && {paths: uPlot.paths.stepped({align: 1})}),
  };
}

/** A time axis in seconds, or hours, minutes and seconds where it is long. */
const seconds = (value) => Math.abs(value) < 600 ? `${value}` : `${Math.floor(value / 60)}:${String(Math.round(value % 60)).padStart(2, '0')}`;

export const X_SECONDS = {label: 'seconds since the measured window began', name: 'time', format: seconds, show: (v) => `${v} s`,
                          axis: {incrs: [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 43200, 86400]}};
/** Distances of ticks where only whole numbers make sense. */
export const WHOLE = {incrs: [1, 2, 4, 8, 16, 32, 64, 128, 256]};

/** Whether values are so far apart that a logarithmic axis shows them better. */
export function needsLogarithm(values) {
  const positive = values.flat().filter((value) => value > 0);
  if (positive.length === 0) return false;
  positive.sort((a, b) => a - b);
  return positive.at(-1) > 25 * positive[positive.length >> 1];
}

/**
 * A figure with a chart and, below it, the table of its figures. `x` is {label, format, show, isLogarithmic}, `y` {label,
 * format, isLogarithmic}; `data` is what uPlot takes: x ascending, then a list for each line. For tests, `figure.plot` is
 * the uPlot.
 */
export function chart(name, title, {x, y, lines, data, figures, note}) {
  const canvas = element('div', {class: 'chart', role: 'img', 'aria-label': `${title}. A table below it has the figures.`});
  const figure = element('figure', {id: `chart-${name}`}, element('figcaption', {}, element('h3', {}, title)), canvas);
  if (note) figure.append(element('p', {class: 'note'}, note));
  figure.append(figures);
  const options = {
    width: 300, height: HEIGHT,
    legend: {live: true, markers: {stroke: (plot, index) => lines[index - 1]?.tone, dash: (plot, index) => lines[index - 1]?.dash ? 'dashed' : 'solid'}},
    cursor: {drag: {x: true, y: false}, points: {size: 7}},
    scales: {x: {time: false, ...(x.isLogarithmic && {distr: 3, log: 10}), ...(x.range && {range: x.range})},
             y: y.isLogarithmic ? {distr: 3, log: 10} : {range: (plot, low, high) => [0, high > 0 ? 1.05 * high : 1]}},
    axes: [axis(x.label, x.format, x.axis), axis(y.isLogarithmic ? `${y.label}, logarithmic` : y.label, y.format ?? milliseconds, {size: 62})],
    series: [{label: x.name ?? x.label, value: (plot, value) => value === null ? '' : (x.show ?? x.format)(value)}, ...lines],
  };
  figure.draw = () => {
    figure.plot = new uPlot(options, data, canvas);
    charts.push(figure);
    new ResizeObserver(() => resize(figure)).observe(canvas);
  };
  return figure;
}

function resize({plot}, width = plot.root.parentElement.clientWidth) {
  if (width > 0 && width !== plot.width) plot.setSize({width, height: HEIGHT});
}

/** Draws the charts below an element, once it is in the page. */
export function drawCharts(root) {
  for (const figure of root.querySelectorAll('figure')) figure.draw?.();
  const redraw = () => charts.forEach(({plot}) => plot.redraw(false, true));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  // Paper is white and has a width of its own.
  addEventListener('beforeprint', () => {
    document.documentElement.classList.add('paper');
    charts.forEach((figure) => resize(figure, PRINT_WIDTH));
    redraw();
  });
  addEventListener('afterprint', () => {
    document.documentElement.classList.remove('paper');
    charts.forEach((figure) => resize(figure));
    redraw();
  });
}
