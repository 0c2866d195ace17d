// SPDX-License-Identifier: Apache-2.0
// Bundles src/ and three.js into dist/viewer.js. `node build.mjs --check` compares instead of writing.
import { build } from 'esbuild';
import { readFileSync, writeFileSync } from 'node:fs';

const licence = readFileSync('node_modules/three/LICENSE', 'utf8').trim();
const { version } = JSON.parse(readFileSync('node_modules/three/package.json', 'utf8'));
const result = await build({
  entryPoints: ['src/main.js'], bundle: true, minify: true, format: 'iife', globalName: 'NdgViewer', target: 'es2022',
  loader: { '.css': 'text' }, charset: 'ascii', legalComments: 'none', write: false,
  banner: { js: `/*! Viewer of Neural Deformation Gradients, SPDX-License-Identifier: Apache-2.0\n\nContains three.js ${version}:\n${licence}\n*/` },
});
// What stands in a script element of a page must not end it.
const text = result.outputFiles[0].text.replaceAll('</script', '<\\/script');
if (process.argv.includes('--check')) {
  if (readFileSync('dist/viewer.js', 'utf8') !== text) {
    console.error('dist/viewer.js is not what src/ gives: make viewer');
    process.exit(1);
  }
  console.log(`dist/viewer.js is what src/ gives (${text.length} bytes)`);
} else {
  writeFileSync('dist/viewer.js', text);
  console.log(`dist/viewer.js: ${text.length} bytes, three.js ${version}`);
}
