// SPDX-License-Identifier: Apache-2.0
// node hdr_log.js FILE: reads a log of histograms with the package hdr-histogram-js, and writes the sum of all intervals
// as JSON.
"use strict";
const fs = require("fs");
const hdr = require("hdr-histogram-js");

const lines = fs.readFileSync(process.argv[2], "utf8").split("\n");
const rows = lines.filter((line) => /^[0-9]/.test(line)).map((line) => line.split(","));
const sum = hdr.build({ numberOfSignificantValueDigits: 3, highestTrackableValue: 86400e6 });
const maxima = [];
for (const [, , max, text] of rows) {
  sum.add(hdr.decodeFromCompressedBase64(text));
  maxima.push(Number(max));
}
process.stdout.write(JSON.stringify({
  intervals: rows.length,
  count: sum.totalCount,
  p50: sum.getValueAtPercentile(50),
  p90: sum.getValueAtPercentile(90),
  p99: sum.getValueAtPercentile(99),
  max: Math.max(...maxima),
}));
