// SPDX-License-Identifier: Apache-2.0
// Errors, options, addresses and checksums.
import assert from 'node:assert/strict';
import {describe, it} from 'node:test';
import zlib from 'node:zlib';
import {ours, theirs} from './package.js';

const {create, toBinary} = await theirs('@bufbuild/protobuf');
const {isRetryable, isWorthReconnecting, SegserveError} = await ours('errors');
const {codeOf, fromStatus} = await ours('status');
const {crc32, crc32ByTables} = await ours('crc32');
const {AddressBook, backoffMs, checkedRetry} = await ours('address_book');
const {parseAddresses} = await ours('node/addresses');
const {METHODS, optionsMessage, outputsMessage} = await ours('options');
const {BadRequestSchema, ErrorInfoSchema, RetryInfoSchema} = await ours('gen/google/rpc/error_details_pb');

const detail = (typeName, schema, value) => ({typeName: `google.rpc.${typeName}`, value: toBinary(schema, create(schema, value))});

describe('errors', () => {
  it('have the details of the server, for programs and people', () => {
    const violation = {field: 'options.lambda', description: '7 is not in [0, 1]'};
    const error = fromStatus('INVALID_ARGUMENT', 'the request is wrong', [
      detail('ErrorInfo', ErrorInfoSchema, {reason: 'INVALID_FIELD', metadata: {limit: 'max_points'}}),
      detail('BadRequest', BadRequestSchema, {fieldViolations: [violation]}),
      detail('RetryInfo', RetryInfoSchema, {retryDelay: {seconds: 1n, nanos: 500_000_000}}),
    ]);
    assert.equal(error.message, 'the request is wrong; options.lambda: 7 is not in [0, 1] (try again in 1500 ms)');
    assert.deepEqual([error.reason, error.metadata, error.fieldViolations, error.retryDelayMs],
                     ['INVALID_FIELD', {limit: 'max_points'}, [violation], 1500]);
    assert.ok(error instanceof SegserveError && error instanceof Error);
  });

  it('do without details that are damaged, unknown or unbelievable', () => {
    const value = Uint8Array.of(255, 255, 255);
    const forever = detail('RetryInfo', RetryInfoSchema, {retryDelay: {seconds: 10n ** 12n}});
    const error = fromStatus('INTERNAL', 'm', [{typeName: 'google.rpc.ErrorInfo', value}, {typeName: 'x', value}, forever]);
    assert.deepEqual([error.message, error.reason, error.retryDelayMs], ['m', '', undefined]);
    assert.deepEqual([codeOf(14), codeOf(0), codeOf(99)], ['UNAVAILABLE', 'UNKNOWN', 'UNKNOWN']);
  });

  it('say whether another try may help', () => {
    const retryable = (code, reason) => isRetryable(new SegserveError(code, '', {reason}));
    assert.deepEqual(['UNAVAILABLE', 'ABORTED', 'CANCELLED', 'RESOURCE_EXHAUSTED', 'INTERNAL', 'DEADLINE_EXCEEDED'].map((code) =>
      retryable(code)), [true, true, true, true, false, false]);
    assert.ok(!retryable('RESOURCE_EXHAUSTED', 'LIMIT_EXCEEDED') && retryable('DEADLINE_EXCEEDED', 'UPLOAD_STALLED'));
    assert.ok(!isWorthReconnecting(new SegserveError('PERMISSION_DENIED', '')));
    assert.ok(isWorthReconnecting(new SegserveError('INTERNAL', '')));
  });
});

describe('options', () => {
  it('have the names of the API in camel case', () => {
    assert.ok(METHODS.includes('border') && METHODS.includes('equalization-convex') && !METHODS.includes('unspecified'));
    const message = optionsMessage({method: 'fixed-lambda', threshold: 0, options: {lambda: 0.5, minSegmentPoints: 10}});
    assert.deepEqual([message.lambda, message.minSegmentPoints, message.cut], [0.5, 10, {case: 'threshold', value: 0}]);
    assert.equal(optionsMessage({preset: 'lidar'}).preset, 4);
    assert.throws(() => optionsMessage({preset: 'street'}), /preset: there is no 'street'; there are auto, tabletop, /);
    assert.throws(() => optionsMessage({options: {preset: 4}}), /options: there is no 'preset'/);
    assert.throws(() => optionsMessage({options: {cropMinX: '1'}}), /cropMinX: 1 is not a number/);
    assert.throws(() => optionsMessage({options: {threads: -1}}), /threads: -1 is not a whole number/);
    assert.throws(() => optionsMessage({options: {regions: 3}}), /options: there is no 'regions'/);
    assert.throws(() => optionsMessage({options: {toString: 3}}), /options: there is no 'toString'/);
    assert.throws(() => outputsMessage(['label'], false), /outputs: there is no 'label'; there are labels, /);
  });
});

describe('addresses', () => {
  it('are separated by commas, and have a port', () => {
    assert.deepEqual(parseAddresses('a, b:1,::1,[::1],[::1]:7,dns:///fleet:9,unix:/run/s'),
                     ['a:50051', 'b:1', '[::1]:50051', '[::1]:50051', '[::1]:7', 'dns:///fleet:9', 'unix:/run/s']);
    for (const wrong of ['', ' ', 'a,', 'https://a', 'a:x', 'a:0', 'a:65536', ':1']) {
      assert.throws(() => parseAddresses(wrong), RangeError);
    }
  });

  it('are tried in turn, and again after a while that doubles', () => {
    const book = new AddressBook(2, 1, checkedRetry(), () => 0);
    assert.deepEqual(book.choose(0), {address: 1, notBefore: 0});
    book.failed(1, 0);
    book.failed(0, 0, 500);
    assert.ok(book.nobodyInReach());
    assert.deepEqual(book.choose(0), {address: 1, notBefore: 50});
    book.failed(1, 50);
    assert.deepEqual(book.choose(50), {address: 1, notBefore: 150});
    book.reached(0);
    assert.deepEqual(book.choose(50), {address: 0, notBefore: 50});
    assert.ok(!book.nobodyInReach());
  });

  it('wait no longer than the limit, and no shorter than the server asked', () => {
    const retry = checkedRetry();
    assert.deepEqual([1, 2, 3, 99].map((attempt) => backoffMs(retry, attempt, undefined, () => 0)), [50, 100, 200, 5000]);
    assert.equal(backoffMs(retry, 1, undefined, () => 1), 25);
    assert.equal(backoffMs(retry, 1, 7000, () => 0), 7000);
    assert.throws(() => checkedRetry({firstBackoffMs: 10, maxBackoffMs: 1}), /retry: the backoffs 10 and 1 ms/);
  });
});

describe('the checksum', () => {
  it('is that of zlib', () => {
    for (const each of [crc32, crc32ByTables]) {
      assert.equal(each(new TextEncoder().encode('123456789')), 0xcbf43926);
      for (let size = 0; size < 40; ++size) {
        const bytes = Uint8Array.from({length: size}, (_, i) => i * 37 + size);
        assert.equal(each(bytes.subarray(size >> 1), each(bytes.subarray(0, size >> 1))), gzipChecksum(bytes));
      }
    }
  });

  /** A gzip file ends with the checksum and the size of its content. */
  function gzipChecksum(bytes) {
    const file = zlib.gzipSync(bytes);
    return file.readUInt32LE(file.length - 8);
  }
});
