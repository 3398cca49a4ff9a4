// SPDX-License-Identifier: Apache-2.0
// Checks a bill of materials against the schema of CycloneDX 1.5: node check.js FILE
import { readFileSync } from "node:fs";
import { Spec, Validation } from "@cyclonedx/cyclonedx-library";

const text = readFileSync(process.argv[2], "utf8");
const faults = await new Validation.JsonStrictValidator(Spec.Version.v1dot5).validate(text);
if (faults) {
  console.error(faults);
  process.exit(1);
}
console.log(`valid CycloneDX 1.5 with ${JSON.parse(text).components.length} components`);
