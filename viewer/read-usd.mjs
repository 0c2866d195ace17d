// SPDX-License-Identifier: Apache-2.0
// Files of USD by TinyUSDZ: node read-usd.mjs FILE... Prints how many meshes each has; exits 1 where one is not read.
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

// The module is made for browsers alone and looks for one.
globalThis.window = globalThis;
globalThis.document = {};
globalThis.location = { href: import.meta.url };
process.type = 'renderer';
const { default: load } = await import('tinyusdz');
const wasm = readFileSync(fileURLToPath(new URL('node_modules/tinyusdz/tinyusdz.wasm', import.meta.url)));
const tiny = await load({ wasmBinary: wasm });
for (const path of process.argv.slice(2)) {
  const scene = new tiny.TinyUSDZLoaderNative();
  const read = scene.loadFromBinary(new Uint8Array(readFileSync(path)), path);
  console.log(`${path}: ${read ? `${scene.numMeshes()} meshes` : scene.error()}`);
  if (!read) process.exitCode = 1;
}
