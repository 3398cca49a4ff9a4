// SPDX-License-Identifier: Apache-2.0
// The client for browsers against a small server of the Connect protocol, whose answers the test chooses.
import assert from 'node:assert/strict';
import http from 'node:http';
import {afterEach, beforeEach, describe, it} from 'node:test';
import {emptyResult, labelBytes} from './fake_server.js';
import {ours, theirs} from './package.js';
import {statusOf} from './stream_harness.js';

const {create, fromBinary, toBinary} = await theirs('@bufbuild/protobuf');
const {Client, SegserveError} = await ours('web');
const {GetServerInfoResponseSchema, SegmentRequestSchema, SegmentResponseSchema} =
    await ours('gen/segserve/v1/segmentation_service_pb');
const CLOUD = {xyz: new Float32Array(60).fill(1), width: 5, height: 4, view: 'camera', outputs: ['labels']};

/** As the protocol has them: https://connectrpc.com/docs/protocol. */
const HTTP_STATUS = {INVALID_ARGUMENT: 400, UNAUTHENTICATED: 401, RESOURCE_EXHAUSTED: 429, UNAVAILABLE: 503};

class ConnectServer {
  errors = [];    // that the next calls get
  requests = [];  // {path, headers, message}
  #server = http.createServer((request, response) => void this.#answer(request, response));

  static async start() {
    const server = new ConnectServer();
    await new Promise((resolve) => { server.#server.listen(0, '127.0.0.1', resolve); });
    server.url = `http://127.0.0.1:${server.#server.address().port}`;
    return server;
  }

  close() {
    this.#server.closeAllConnections();
    this.#server.close();
  }

  async #answer(request, response) {
    const parts = [];
    for await (const part of request) parts.push(part);
    this.requests.push({path: request.url, headers: request.headers, body: Buffer.concat(parts)});
    const error = this.errors.shift();
    if (error !== undefined) {
      const {message, details} = statusOf(error);
      const body = {code: error.code.toLowerCase(), message,
                    details: details.map(({typeUrl, value}) => ({type: typeUrl.split('/')[1],
                                                                 value: Buffer.from(value).toString('base64').replace(/=*$/, '')}))};
      response.writeHead(HTTP_STATUS[error.code], {'content-type': 'application/json'}).end(JSON.stringify(body));
      return;
    }
    response.writeHead(200, {'content-type': 'application/proto'}).end(request.url.endsWith('/Segment') ? this.#segment() :
      toBinary(GetServerInfoResponseSchema, create(GetServerInfoResponseSchema, {version: 'fake'})));
  }

  #segment() {
    const {cloud} = fromBinary(SegmentRequestSchema, this.requests.at(-1).body);
    const result = emptyResult(cloud.width * cloud.height);
    result.labels.data = {data: labelBytes(cloud.width * cloud.height)};
    return toBinary(SegmentResponseSchema, create(SegmentResponseSchema, {result}));
  }
}

let server, client;
beforeEach(async () => {
  server = await ConnectServer.start();
  client = new Client(server.url, {token: 'secret'});
});
afterEach(() => server.close());

const refusal = (code, reason, retryDelayMs) => new SegserveError(code, 'no', {reason, retryDelayMs});

describe('the client for browsers', () => {
  it('segments by the Connect protocol', async () => {
    const result = await client.segment({...CLOUD, frameId: 'f', timeoutMs: 5000});
    assert.deepEqual([result.labels, result.frameId], [new Uint32Array(20).fill(1), 'f']);
    const [{path, headers}] = server.requests;
    assert.equal(path, '/segserve.v1.SegmentationService/Segment');
    assert.deepEqual([headers['content-type'], headers['connect-protocol-version'], headers.authorization],
                     ['application/proto', '1', 'Bearer secret']);
    assert.ok(Number(headers['connect-timeout-ms']) <= 5000);
  });

  it('asks what the server can do', async () => {
    assert.equal((await client.info()).version, 'fake');
  });

  it('tells errors as the client for Node does', async () => {
    server.errors = [refusal('INVALID_ARGUMENT', 'INVALID_FIELD')];
    await assert.rejects(client.info(), {name: 'SegserveError', code: 'INVALID_ARGUMENT', reason: 'INVALID_FIELD', message: 'no'});
    server.close();
    await assert.rejects(client.info(), {code: 'UNAVAILABLE', message: /^no answer from http:.*: fetch failed; is segserve --http/});
  });

  it('repeats a call, also at another address', async () => {
    server.errors = [refusal('RESOURCE_EXHAUSTED', 'QUEUE_FULL', 200)];
    const began = performance.now();
    await client.info();
    assert.ok(performance.now() - began >= 190);
    const other = await ConnectServer.start();
    server.errors = [refusal('UNAVAILABLE', 'DRAINING', 60_000)];
    await new Client(`${server.url},${other.url}`).info();
    assert.equal(other.requests.length, 1);
    other.close();
  });

  it('can be cancelled', async () => {
    await assert.rejects(client.segment({...CLOUD, signal: AbortSignal.abort()}), {code: 'CANCELLED'});
    server.errors = [refusal('RESOURCE_EXHAUSTED', 'QUEUE_FULL', 20_000)];
    const stop = new AbortController();
    setTimeout(() => stop.abort(), 50);
    await assert.rejects(client.info({signal: stop.signal}), {code: 'CANCELLED'});
  });

  it('refuses what makes no sense before anything is sent', async () => {
    await assert.rejects(client.segment({xyz: new Float32Array(3_000_000), view: 'camera'}), /at most 8388608 fit into a message/);
    for (const [url, options, why] of [['ftp://a', {}, /no URL such as/], ['a:8443', {}, /no URL such as/], ['https://a?b', {}, /no URL/],
                                       ['http://a', {token: 'x'}, /cross the network to http:\/\/a/], ['https://a', {tls: {}}, /no 'tls'/]]) {
      assert.throws(() => new Client(url, options), why);
    }
    new Client('https://a,https://b/prefix/', {token: 'x'});
    assert.equal(server.requests.length, 0);
  });
});
