// SPDX-License-Identifier: Apache-2.0
// Reads the data that segctl view wrote into the page. An array is the base64 of a gzip of its values, little endian. Of
// integers and of the bits of floats, the differences to the value before are stored, and of these first all lowest bytes,
// then all second ones, and so on: neighbors are alike, so that this makes small files.

const TYPES = {
  u8: {Bits: Uint8Array, Values: Uint8Array},
  u16: {Bits: Uint16Array, Values: Uint16Array},
  u32: {Bits: Uint32Array, Values: Uint32Array},
  f32: {Bits: Uint32Array, Values: Float32Array},
};

/** The bytes of a text in base64, piece by piece, so that no copy of the whole is made. */
function* bytesOfBase64(text) {
  const piece = 4 << 18;  // A multiple of 4, so that each piece is base64 by itself.
  for (let at = 0; at < text.length; at += piece) {
    const binary = atob(text.slice(at, at + piece));
    const bytes = new Uint8Array(binary.length);
    for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
    yield bytes;
  }
}

/** Decompresses exactly `length` bytes. */
async function inflate(text, length) {
  const pieces = bytesOfBase64(text);
  const compressed = new ReadableStream({
    pull(controller) {
      const {value, done} = pieces.next();
      if (done) controller.close(); else controller.enqueue(value);
    },
  });
  const result = new Uint8Array(length);
  let at = 0;
  const reader = compressed.pipeThrough(new DecompressionStream('gzip')).getReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    if (at + part.value.length > length) throw new Error('The data of this page is longer than it says.');
    result.set(part.value, at);
    at += part.value.length;
  }
  if (at !== length) throw new Error('The data of this page is not complete.');
  return result;
}

/** Puts planes of bytes together to the differences that they are, and adds these up. */
function valuesOfPlanes(planes, count, {Bits, Values}) {
  const bits = new Bits(count);
  const width = Bits.BYTES_PER_ELEMENT;
  for (let i = 0, value = 0; i < count; ++i) {
    let step = 0;
    for (let byte = 0; byte < width; ++byte) step |= planes[byte * count + i] << (8 * byte);
    bits[i] = value = (value + step) | 0;
  }
  return new Values(bits.buffer);
}

/** An array by its description {type, count, id}; `textOf` gives the text that the page has under an id. */
export async function readArray({type, count, id}, textOf) {
  if (type === 'f64') return new Float64Array((await inflate(textOf(id), 8 * count)).buffer);
  const planes = await inflate(textOf(id), TYPES[type].Bits.BYTES_PER_ELEMENT * count);
  return valuesOfPlanes(planes, count, TYPES[type]);
}

/** Reads all arrays of an object name -> description, one after the other. */
export async function readArrays(descriptions, textOf) {
  const arrays = {};
  for (const [name, description] of Object.entries(descriptions)) {
    arrays[name] = await readArray(description, textOf);
  }
  return arrays;
}
