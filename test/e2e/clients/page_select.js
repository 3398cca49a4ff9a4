// SPDX-License-Identifier: Apache-2.0
// Selects nodes of the merge tree as the page of segctl view does, without a browser.
//
//   node page_select.js PAGE.html QUERIES.json
//
// QUERIES is an array of {include, exclude, candidate}, where the first two are arrays of leaves. The answer is an array of
// {candidates: [{nodes, points, thresholds}], centroid, half_extents, color}, of which the last three describe the
// candidate.
'use strict';
const fs = require('fs');
const path = require('path');

const source = path.join(__dirname, '../../../client/page/src');
const [page, queries] = process.argv.slice(2);

async function main() {
  const {load} = await import(path.join(source, 'loading.js'));
  const {nodesOf, select, thresholdsOf} = await import(path.join(source, 'selection.js'));
  const texts = new Map();
  for (const [, id, text] of fs.readFileSync(page, 'utf8').matchAll(/<script type="[^"]*" id="([^"]*)">([^<]*)<\/script>/g)) {
    texts.set(id, text);
  }
  const {sides: [side]} = await load(JSON.parse(texts.get('page-data')), (id) => texts.get(id));
  const {tree} = side;
  const answer = ({include, exclude, candidate}) => {
    side.selection = select(tree, include, exclude);
    side.size = candidate;
    const candidates = Array.from({length: side.selection.steps.length + 1}, (_, k) => {
      const nodes = nodesOf(side.selection, k), {from, to} = thresholdsOf(tree, side.selection, k);
      return {nodes, points: nodes.reduce((sum, node) => sum + tree.points[node], 0), thresholds: [from, to]};
    });
    const {centroid, box, color} = side.describeChosen();
    return {candidates, centroid, half_extents: box.halfExtents, color};
  };
  console.log(JSON.stringify(JSON.parse(fs.readFileSync(queries, 'utf8')).map(answer)));
}

main();
