// SPDX-License-Identifier: Apache-2.0
// The page of a server: files that are dropped on it are segmented there, and come back as what the page draws.
import {byId} from './dom.js';

const VIEW_TYPE = 'application/vnd.segserve.view+json';

/** Whether these first bytes are those of a depth image: PNG, gray with 16 bits, PGM or PFM. */
export function isDepthImage(bytes) {
  const text = String.fromCharCode(...bytes.subarray(0, 4));
  if (text === '\u0089PNG') return bytes[24] === 16 && bytes[25] === 0;
  return /^(P[25]\s|Pf\s)/.test(text);
}

const isImage = (name) => /\.(png|jpe?g|pgm|ppm|pfm)$/i.test(name);

/**
 * The request for dropped files: {query, body}. A single file is sent as it is; a pair of images is a form. Throws an
 * Error with a sentence for people if the files are neither.
 */
export async function requestFor(files, intrinsics) {
  const [first, second] = files;
  const query = new URLSearchParams({name: first.name.slice(0, 80)});
  if (files.length === 1 && !isImage(first.name)) return {query, body: first};
  if (files.length > 2) throw new Error('Drop one file of a cloud, or a depth image with its color image.');
  const heads = await Promise.all(files.map(async (file) => new Uint8Array(await file.slice(0, 32).arrayBuffer())));
  const depth = heads.findIndex(isDepthImage);
  if (depth < 0) throw new Error('None of these is a depth image: a PNG with 16 bits, a PGM or a PFM file.');
  const body = new FormData();
  body.append('depth', files[depth]);
  if (second) body.append('color', files[1 - depth]);
  query.set('intrinsics', intrinsics.replace(/\s/g, ''));
  return {query, body};
}

/** The sentence of an answer that is an error. */
async function errorOf(response) {
  const text = await response.text();
  try {
    return JSON.parse(text).error.message;
  } catch {
    return text.trim() || `The server answered ${response.status}.`;
  }
}

const namesOf = (files) => files.map(({name}) => name).join(' and ');

/** What is said when the files were segmented. */
export const doneText = (files) => `${namesOf(files)} ${files.length > 1 ? 'were' : 'was'} segmented.`;

/** Sends the files and returns what load() reads: {data, textOf}. */
async function segment(files, {intrinsics, token}) {
  const {query, body} = await requestFor(files, intrinsics);
  const headers = {Accept: VIEW_TYPE};
  if (token) headers.Authorization = `Bearer ${token}`;
  if (!(body instanceof FormData)) headers['Content-Type'] = 'application/octet-stream';
  const response = await fetch(`v1/segment?${query}`, {method: 'POST', headers, body});
  if (!response.ok) throw new Error(await errorOf(response));
  const {page, arrays} = await response.json();
  return {data: page, textOf: (id) => arrays[id]};
}

/** Lets files be dropped or chosen. `show` gets what load() reads, and may take its time. */
export function startUploads(show) {
  byId('open').hidden = false;
  byId('drop').hidden = false;
  let isBusy = false;

  const say = (text, isError = false) => {
    byId('open-message').textContent = text;
    byId('open-message').dataset.failed = String(isError);
    byId('drop-message').textContent = text;
  };

  const open = async (files) => {
    if (isBusy || files.length === 0) return;
    isBusy = true;
    say(`Segmenting ${namesOf(files)} …`);
    try {
      const settings = {intrinsics: byId('intrinsics').value, token: byId('token').value.trim()};
      await show(await segment(files, settings));
      byId('drop').hidden = true;
      say(doneText(files));
    } catch (error) {
      say(error.message, true);
    }
    isBusy = false;
  };

  byId('open-file').addEventListener('click', () => byId('file').click());
  byId('file').addEventListener('change', ({target}) => {
    open([...target.files]);
    target.value = '';  // so that the same file can be chosen again
  });
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', (event) => {
    event.preventDefault();
    open([...event.dataTransfer.files]);
  });
}
