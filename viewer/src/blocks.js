// SPDX-License-Identifier: Apache-2.0
// Tables of numbers as lib/ndg/page/page_blocks.cpp writes them.

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function unpackFloats(planes, count) {
  const bytes = new Uint8Array(4 * count);
  for (let k = 0; k < 4; ++k) for (let i = 0; i < count; ++i) bytes[4 * i + k] = planes[k * count + i];
  return new Float32Array(bytes.buffer);
}

/** Undoes the differences to the row before, in the first row to `stride` values before. */
function unpackValues(planes, count, row, stride) {
  const values = new Uint16Array(count);
  for (let i = 0; i < count; ++i) {
    const before = i >= row ? values[i - row] : i >= stride ? values[i - stride] : 0;
    values[i] = before + (planes[i] | (planes[count + i] << 8));
  }
  return values;
}

/** The numbers of a block: Uint16Array or Float32Array of block.count values. */
export async function decode(block) {
  const planes = await inflate(bytesOf(block.data));
  if (block.floats) return unpackFloats(planes, block.count);
  return unpackValues(planes, block.count, block.row ?? block.count, block.stride);
}
