// SPDX-License-Identifier: Apache-2.0
// Names that callers give.

/** The name, if it is one of those known. RangeError, which lists them, if not. */
export function oneOf<Name extends string>(what: string, name: string, known: readonly Name[]): Name {
  if (!(known as readonly string[]).includes(name)) {
    throw new RangeError(`${what}: there is no '${name}'; there are ${known.join(', ')}`);
  }
  return name as Name;
}

/** The names of the properties of all members of a union. */
export type NamesOf<Union> = Union extends unknown ? keyof Union : never;

/** TypeError, which lists the known ones, if there is a property of another name. */
export function refuseUnknown<Given extends object>(what: string, given: Given, known: Record<NamesOf<Given>, true>): void {
  for (const name of Object.keys(given)) {
    if (!Object.hasOwn(known, name)) throw new TypeError(`${what}: there is no '${name}'; there are ${Object.keys(known).join(', ')}`);
  }
}
