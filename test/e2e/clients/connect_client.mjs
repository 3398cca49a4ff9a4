// SPDX-License-Identifier: Apache-2.0
// Calls the web entrance by the protocol Connect, as a browser would with @connectrpc/connect-web, whose transport this is.
//
//   node connect_client.mjs NODE_MODULES MESSAGES.js BASE_URL SCENE.pcd json|proto
//
// Prints a JSON object: what the server told of itself, the labels, and the error of a wrong request.
import {createRequire} from 'node:module';
import {readFileSync} from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const [modules, messages, baseUrl, scene, format] = process.argv.slice(2);
const require = createRequire(path.join(modules, 'any.js'));
const {createClient, Code, ConnectError} = require('@connectrpc/connect');
const {createConnectTransport} = require('@connectrpc/connect-web');
const {SegmentationService} = await import(pathToFileURL(path.join(messages, 'segserve/v1/segmentation_service_pb.js')));
const {ErrorInfoSchema, BadRequestSchema} = await import(pathToFileURL(path.join(messages, 'google/rpc/error_details_pb.js')));

const client = createClient(SegmentationService, createConnectTransport({baseUrl, useBinaryFormat: format === 'proto'}));
const request = {cloud: {payload: {case: 'pcdFile', value: {file: {data: readFileSync(scene)}}}},
                 outputs: {labels: true, tree: true}, requestId: 'from node'};

const info = await client.getServerInfo({});
const {result, requestId} = await client.segment(request, {timeoutMs: 20_000});
const {count, bytesPerValue, data} = result.labels;
const labels = Array.from({length: Number(count)}, (_, i) => {
  let value = 0;
  for (let byte = 0; byte < bytesPerValue; ++byte) value |= data.data[i * bytesPerValue + byte] << (8 * byte);
  return value;
});

async function errorOf(call) {
  try {
    await call();
  } catch (error) {
    const {code, rawMessage} = ConnectError.from(error);
    return {code: Code[code], message: rawMessage, reasons: error.findDetails(ErrorInfoSchema).map(({reason}) => reason),
            fields: error.findDetails(BadRequestSchema).flatMap(({fieldViolations}) => fieldViolations.map(({field}) => field))};
  }
  return null;
}

console.log(JSON.stringify({
  version: info.version, requestId, labels, segments: result.summary.segments,
  wrong: await errorOf(() => client.segment({...request, options: {lambda: 7, seedResolution: -1}})),
  late: await errorOf(() => client.segment(request, {timeoutMs: 1})),
}));
