// SPDX-License-Identifier: Apache-2.0
// Checks Kubernetes' files against the schemas of Kubernetes and of the operators that they use: node check.js FILE..
// A value of the wrong type or form is found by the schemas, and a field that does not exist by the types of TypeScript.
import { readFileSync } from "node:fs";
import { basename } from "node:path";
import ts from "typescript";
import { parseAllDocuments } from "yaml";

const packageOfGroup = {
  "cert-manager.io": "@kubernetes-models/cert-manager",
  "gateway.envoyproxy.io": "@kubernetes-models/envoy-gateway",
  "gateway.networking.k8s.io": "@kubernetes-models/gateway-api",
  "keda.sh": "@kubernetes-models/keda",
  "monitoring.coreos.com": "@kubernetes-models/prometheus-operator",
};

/** The module that has the class of a resource, e.g. "kubernetes-models/apps/v1". */
function moduleOf(apiVersion) {
  const [group, version] = apiVersion.includes("/") ? apiVersion.split("/") : ["", apiVersion];
  if (group in packageOfGroup) return `${packageOfGroup[group]}/${group}/${version}`;
  return ["kubernetes-models", group, version].filter(Boolean).join("/");
}

async function schemaFaults(resource) {
  const classes = await import(moduleOf(resource.apiVersion));
  if (!(resource.kind in classes)) return [`${resource.apiVersion} has no kind ${resource.kind}`];
  try {
    new classes[resource.kind](resource).validate();
    return [];
  } catch (error) {
    return [error.message];
  }
}

/** The faults that the compiler finds in a program which has each resource as a literal of its type. */
function typeFaults(resources) {
  const lines = resources.map(({ resource }, index) =>
    `import type { I${resource.kind} as T${index} } from "${moduleOf(resource.apiVersion)}"; ` +
    `export const r${index}: T${index} = ${JSON.stringify(resource)};`);
  const name = `${import.meta.dirname}/resources.ts`;
  const options = { module: ts.ModuleKind.NodeNext, strict: true, noEmit: true, skipLibCheck: true, types: [] };
  const host = ts.createCompilerHost(options);
  const { getSourceFile, fileExists } = host;
  host.getSourceFile = (file, ...rest) =>
    file === name ? ts.createSourceFile(name, lines.join("\n"), ts.ScriptTarget.Latest) : getSourceFile(file, ...rest);
  host.fileExists = (file) => file === name || fileExists(file);
  const program = ts.createProgram([name], options, host);
  return ts.getPreEmitDiagnostics(program).map((fault) => {
    const line = fault.file?.fileName === name ? fault.file.getLineAndCharacterOfPosition(fault.start).line : undefined;
    return { ...resources[line], message: ts.flattenDiagnosticMessageText(fault.messageText, "\n") };
  });
}

const resources = process.argv.slice(2).flatMap((file) =>
  parseAllDocuments(readFileSync(file, "utf8")).map((document) => ({ file, resource: document.toJS() })));
const faults = typeFaults(resources);
for (const { file, resource } of resources) {
  for (const message of await schemaFaults(resource)) faults.push({ file, resource, message });
}
for (const { file, resource, message } of faults) {
  const where = file ? `${basename(file)}: ${resource.kind} ${resource.metadata?.name}` : "the check itself";
  console.error(`${where}: ${message}`);
}
console.log(`${resources.length} resources, ${faults.length} faults`);
if (faults.length > 0 || resources.length === 0) process.exit(1);
