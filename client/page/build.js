// SPDX-License-Identifier: Apache-2.0
// Bundles a page into one HTML file without its data, which segctl adds, and into a source with the same text.
//
//   node build.js NODE_MODULES FOLDER OUTPUT.html [OUTPUT.cpp NAME]
//
// FOLDER has page.html, main.js and style.css. NAME is that of the text in C++.
//
// The page runs this script and this style and no others: their hashes stand in its Content-Security-Policy. It loads
// nothing. A server lets it ask that server (bundled_pages.cpp).
import {createHash} from 'node:crypto';
import {readFileSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';

const [modules, source, output, cppOutput] = process.argv.slice(2, 6).map((name) => path.resolve(name));
const symbol = process.argv[6];
const {build} = createRequire(path.join(modules, 'any.js'))('esbuild');

async function bundle(name) {
  const {outputFiles} = await build({
    entryPoints: [path.join(source, name)],
    nodePaths: [modules],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: 'es2022',
    legalComments: 'inline',
    logLevel: 'warning',
  });
  const {text} = outputFiles[0];
  if (/<\/(script|style)/i.test(text)) throw new Error(`${name} would end its element.`);
  return text;
}

const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const [script, style] = [await bundle('main.js'), await bundle('style.css')];
const policy = [`default-src 'none'`, `script-src ${hash(script)}`, `style-src ${hash(style)}`, `img-src data: blob:`,
                `connect-src 'none'`, `base-uri 'none'`, `form-action 'none'`].join('; ');
// Functions, because "$&" in a replacement text would mean something.
const page = readFileSync(path.join(source, 'page.html'), 'utf8')
    .replace('POLICY', () => policy).replace('STYLE', () => style);
// The data come before the script, so that they are there when it runs.
const html = `${page}<!--DATA-->\n<script>${script}</script>\n</body>\n</html>\n`;
writeFileSync(output, html);

/** Bytes as string literals of C++. Octal escapes have three digits, so that no digit after them belongs to them. */
function literals(bytes) {
  const escape = (byte) => (byte < 32 || byte > 126 || byte === 34 || byte === 92 || byte === 63
      ? `\\${byte.toString(8).padStart(3, '0')}` : String.fromCharCode(byte));
  const lines = [];
  for (let at = 0; at < bytes.length; at += 4096) lines.push(`"${Array.from(bytes.subarray(at, at + 4096), escape).join('')}"`);
  return lines.join('\n');
}

if (cppOutput) {
  writeFileSync(cppOutput, `// This file was made by client/page/build.js.
#include <string_view>
namespace segserve::page {
extern const std::string_view ${symbol};
const std::string_view ${symbol} = std::string_view(
${literals(Buffer.from(html))}, ${Buffer.byteLength(html)});
}  // namespace segserve::page
`);
}
