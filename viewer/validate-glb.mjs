// SPDX-License-Identifier: Apache-2.0
// Files of glTF by the validator of the Khronos Group: node validate-glb.mjs FILE... Exits 1 where it finds errors.
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

for (const path of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(path)), { maxIssues: 20 });
  const { numErrors, numWarnings, messages } = report.issues;
  const { drawCallCount, totalVertexCount, animationCount, hasMorphTargets } = report.info;
  console.log(`${path}: ${numErrors} errors, ${numWarnings} warnings; ${drawCallCount} meshes, ${totalVertexCount} vertices, `
    + `${animationCount} animations, morph targets: ${hasMorphTargets}`);
  for (const { severity, code, message, pointer } of messages) if (severity < 2) console.log(`  ${code} at ${pointer}: ${message}`);
  if (numErrors > 0) process.exitCode = 1;
}
