// SPDX-License-Identifier: Apache-2.0
// Where the time of a frame goes, in groups.

const GROUP_OF = {
  client_encode: 'client', client_wait: 'client', client_decode: 'client', queue: 'queue', rest: 'transport', transport: 'transport',
};

/** The groups in the order in which they are drawn, with names for people. */
export const GROUPS = {client: 'Client', queue: 'Queue', server: 'Stages at the server', transport: 'Transport and rest'};

/** The parts of "stages_ms": [{stage, group, ms}]. A stage that is not known is one of the server. */
export function parts(stages) {
  return Object.entries(stages).filter(([stage]) => stage !== 'total')
    .map(([stage, ms]) => ({stage, group: Object.hasOwn(GROUP_OF, stage) ? GROUP_OF[stage] : 'server', ms: ms ?? 0}));
}

/** The sum of each group in milliseconds. */
export function sums(stages) {
  const of = Object.fromEntries(Object.keys(GROUPS).map((group) => [group, 0]));
  for (const {group, ms} of parts(stages)) of[group] += ms;
  return of;
}
