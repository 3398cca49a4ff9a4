// SPDX-License-Identifier: Apache-2.0
// Builds the package: generates the messages from proto/ and compiles everything to dist/.
//
//   node build.js [FOLDER [MODULES]]
//
// FOLDER is where the package comes to be, by default this folder. MODULES is the folder node_modules with the packages of
// package-lock.json, by default that of FOLDER. The build needs protoc (Debian: protobuf-compiler).
import {spawnSync} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import {fileURLToPath} from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
const repository = path.resolve(here, '../..');
const output = path.resolve(process.argv[2] ?? here);
const modules = path.resolve(process.argv[3] ?? path.join(output, 'node_modules'));

const PROTO = path.join(repository, 'proto');
const HEALTH = path.join(repository, 'client/python/proto');
const MESSAGES = ['google/rpc/error_details', 'google/rpc/status', 'segserve/v1/block', 'segserve/v1/cloud',
                  'segserve/v1/error_reason', 'segserve/v1/options', 'segserve/v1/prompts', 'segserve/v1/result', 'segserve/v1/segment',
                  'segserve/v1/segmentation_service', 'segserve/v1/server_info', 'segserve/v1/stream', 'segserve/v1/tracking',
                  'health'];

function run(command, ...options) {
  const done = spawnSync(command, options, {cwd: output, encoding: 'utf8'});
  if (done.error?.code === 'ENOENT') fail(`segserve: ${command} is needed to build this package`);
  if (done.error || done.status !== 0) fail(`${command}: ${done.error ?? `${done.stdout}${done.stderr}`}`);
}

function fail(why) {
  console.error(why);
  process.exit(1);
}

/** Copies the sources to build/, and generates the messages beside them. */
function gather() {
  const build = path.join(output, 'build');
  fs.rmSync(build, {recursive: true, force: true});
  fs.cpSync(path.join(here, 'src'), build, {recursive: true});
  const generated = path.join(build, 'gen');
  fs.mkdirSync(generated);
  run('protoc', `--plugin=protoc-gen-es=${path.join(modules, '.bin/protoc-gen-es')}`, `--proto_path=${PROTO}`,
      `--proto_path=${HEALTH}`, `--es_out=${generated}`, '--es_opt=target=ts,import_extension=js',
      ...MESSAGES.map((name) => `${name}.proto`));
}

function compile() {
  const dist = path.join(output, 'dist');
  fs.rmSync(dist, {recursive: true, force: true});
  run(path.join(modules, '.bin/tsc'), '--project', path.join(output, 'tsconfig.json'));
  fs.copyFileSync(path.join(repository, 'LICENSE'), path.join(dist, 'LICENSE'));
}

if (output !== here) {
  fs.mkdirSync(output, {recursive: true});
  for (const name of ['package.json', 'README.md', 'tsconfig.json']) fs.copyFileSync(path.join(here, name), path.join(output, name));
  const link = path.join(output, 'node_modules');
  fs.rmSync(link, {recursive: true, force: true});
  fs.symlinkSync(modules, link);
}
gather();
compile();
