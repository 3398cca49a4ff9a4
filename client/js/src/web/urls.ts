// SPDX-License-Identifier: Apache-2.0
// Where web entrances are.

const LOOPBACKS = /^(localhost|127\.\d+\.\d+\.\d+|\[::1\])$/;

/** Splits a list at its commas. RangeError unless each is a URL of http or https, without search and fragment. */
export function parseUrls(text: string): string[] {
  if (typeof text !== 'string') throw new TypeError(`url: it must be a text, not ${typeof text}`);
  return text.split(',').map((word) => {
    const url = parsed(word.trim());
    if (url === undefined || !['http:', 'https:'].includes(url.protocol) || url.search !== '' || url.hash !== '') {
      throw new RangeError(`url: '${word.trim()}' is no URL such as https://robots.example:8443`);
    }
    return url.href.replace(/\/$/, '');
  });
}

function parsed(word: string): URL | undefined {
  try {
    return new URL(word);
  } catch {
    return undefined;
  }
}

/** Whether nobody can read what is sent there. */
export function isProtected(url: string): boolean {
  const {protocol, hostname} = new URL(url);
  return protocol === 'https:' || LOOPBACKS.test(hostname);
}
