// SPDX-License-Identifier: Apache-2.0
// What the server tells of itself, and with what it was measured.
import {element} from '../src/dom.js';
import {bytes, fixed, isNumber, milliseconds, text, whole} from './figures.js';
import {facts, numbers, table, texts} from './table.js';

/** An entry of a list: the name of an object that has one. */
const entryText = (entry) => entry !== null && typeof entry === 'object' ? entry.name ?? JSON.stringify(entry) : entry;

/** Objects in objects become rows "a.b". */
function flat(object, prefix = '') {
  return Object.entries(object ?? {}).flatMap(([key, value]) => value !== null && typeof value === 'object' && !Array.isArray(value)
    ? flat(value, `${prefix}${key}.`) : [[`${prefix}${key}`, Array.isArray(value) ? value.map(entryText).join(', ') : value]]);
}

function metrics({server_metrics: told}) {
  if (!told) return [];
  const rows = [
    ['queue wait p50, ms', told.queue_wait_ms?.p50, milliseconds], ['queue wait p99, ms', told.queue_wait_ms?.p99, milliseconds],
    ['CPU seconds', told.cpu_seconds, fixed(2)], ['CPU, ms a frame', told.cpu_ms_per_frame, fixed(2)],
    ['most memory', told.memory_bytes_max, bytes], ...Object.entries(told.rejected ?? {}).map(([reason, n]) => [`rejected: ${reason}`, n, whole])];
  const made = [element('h2', {}, 'What the server measured'), facts('server-metrics', 'Metrics of the server over this load test', rows)];
  const before = Object.fromEntries(flat(told.before)), after = Object.fromEntries(flat(told.after));
  const families = [...new Set([...Object.keys(before), ...Object.keys(after)])];
  const shown = (value) => isNumber(value) ? String(value) : text(value);
  if (families.length > 0) {
    made.push(element('details', {}, element('summary', {}, 'Before and after'), table('server-families', 'Metrics before and after', [
      texts('metric', (family) => family), numbers('before', (family) => before[family], shown), numbers('after', (family) => after[family], shown)],
    families)));
  }
  return made;
}

function host({host: machine, client_build: build, server_info: server}) {
  if (!machine && !build && !server) return [];
  const rows = [
    ['machine', machine?.name], ['CPUs', machine && [machine.cpus, machine.cpu_model].filter((part) => part !== undefined).join(' x ')],
    ['memory', machine?.memory_bytes, bytes], ['kernel', machine?.kernel], ['load before', machine?.load_before, fixed(2)],
    ['segctl', build && [build.version, build.compiler, build.build_type].filter(Boolean).join(', ')],
    ...flat(server).map(([key, value]) => [`server: ${key}`, value])];
  return [element('h2', {}, 'Machine and programs'), facts('host', 'The machine of segctl, and what the server tells of itself', rows)];
}

/** A word of the command as a shell wants it. */
const quoted = (word) => /^[\w@%+=:,.\/-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;

function configuration(run) {
  const rows = [
    ['server', run.server], ['loop', run.loop], ['arrivals', run.arrivals ?? undefined], ['speed', run.speed ?? undefined],
    ['clients', run.clients, whole], ['in flight, each client', run.in_flight, whole], ['codec', run.codec],
    ['encoded beforehand', run.encoded_beforehand === undefined ? undefined : run.encoded_beforehand ? 'yes' : 'no'],
    ['warm-up, s', run.window?.warm_up_s, fixed(1)], ['measured, s', run.window?.measured_s ?? run.seconds, fixed(1)],
    ['drained for, s', run.window?.drain_s, fixed(1)],
    ['verified', isNumber(run.verified) ? `${whole(run.verified)} label arrays, ${whole(run.mismatches)} differ` : undefined]];
  const made = [element('h2', {}, 'Configuration'), facts('configuration', 'The load', rows)];
  if (run.command) made.push(element('pre', {}, element('code', {id: 'command'}, run.command.map(quoted).join(' '))));
  return made;
}

export const setupSections = (run) => [...metrics(run), ...host(run), ...configuration(run)];
