// SPDX-License-Identifier: Apache-2.0
// How addresses of servers are written.

export const DEFAULT_PORT = 50051;
const RESOLVERS = ['dns:', 'unix:', 'unix-abstract:', 'ipv4:', 'ipv6:', 'xds:'];
const LOOPBACKS = ['127.', 'localhost:', '[::1]', 'unix:', 'unix-abstract:'];

/**
 * Splits a list at its commas, and gives hosts without a port the default one. A name that gRPC resolves
 * ("dns:///name:50051", "unix:/path") is one address even if it stands for many servers.
 *
 * RangeError if there is no address, or one of them is empty, a URL, or has no number as its port.
 */
export function parseAddresses(text: string): string[] {
  if (typeof text !== 'string') throw new TypeError(`address: it must be a text, not ${typeof text}`);
  if (text.trim() === '') throw new RangeError('address: it is empty');
  return text.split(',').map((address) => withPort(address.trim(), text));
}

function withPort(address: string, text: string): string {
  if (address === '') throw new RangeError(`address: there is an empty one in '${text}'`);
  if (RESOLVERS.some((prefix) => address.startsWith(prefix))) return address;
  if (address.includes('/')) {
    throw new RangeError(`address: '${address}' is a URL; a server's address is HOST:PORT, such as 127.0.0.1:${DEFAULT_PORT}`);
  }
  if (!address.startsWith('[') && address.split(':').length > 2) return `[${address}]:${DEFAULT_PORT}`;
  const colon = address.lastIndexOf(':');
  if (colon < 0 || address.endsWith(']')) return `${address}:${DEFAULT_PORT}`;
  const port = address.slice(colon + 1);
  if (colon === 0 || !/^\d{1,5}$/.test(port) || Number(port) < 1 || Number(port) > 65535) {
    throw new RangeError(`address: the port of '${address}' is no number from 1 to 65535`);
  }
  return address;
}

/** Whether it is on this machine. */
export function isLoopback(address: string): boolean {
  return LOOPBACKS.some((prefix) => address.startsWith(prefix));
}
