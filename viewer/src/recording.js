// SPDX-License-Identifier: Apache-2.0
// What a page holds of the motion: topology, the body at rest, and the frames as they arrive.

/** Sums of wedges are by this table of the sides of a prism: corners (inner i, inner j, outer j, outer i). */
const prismSides = [[3, 4, 1, 0], [4, 5, 2, 1], [5, 3, 0, 2]];

export class Recording {
  constructor(head) {
    Object.assign(this, {
      head, tables: {}, common: [], motions: [], methods: head.methods.map(() => []),
      numPoints: head.num_common + head.num_method, numFrames: head.num_frames,
    });
    this.numLoaded = 0;
  }

  /** Takes a decoded block. */
  add(block, values) {
    if (block.frame === undefined) {
      this.tables[block.name] = values;
      return;
    }
    const frames = block.name === 'common' ? this.common : block.name === 'motions' ? this.motions
      : this.methods[Number(block.name.slice('method_'.length))];
    for (let i = 0; i * block.row < values.length; ++i)
      frames[block.frame + i] = values.subarray(i * block.row, (i + 1) * block.row);
    const complete = (f) => this.common[f] && this.motions[f] && this.methods.every((m) => m[f]);
    while (this.numLoaded < this.numFrames && complete(this.numLoaded)) ++this.numLoaded;
  }

  /** All that has to be there before anything can be shown. */
  get ready() { return this.tables.rest !== undefined && this.numLoaded > 0; }

  /** Index of the first point of a wrap: 0 bone wrap, 1 muscle wrap, 2 skin wrap. */
  wrapBegin(wrap) {
    return wrap === 0 ? 0 : this.head.num_common + (wrap - 1) * this.head.num_wrap;
  }

  /** Point indices of the triangles of a wrap. */
  wrapTriangles(wrap) {
    const begin = this.wrapBegin(wrap);
    return Uint32Array.from(this.tables.wrap_triangles, (v) => begin + v);
  }

  /** A page may show a skin with nothing inside. */
  get hasFlesh() { return this.head.num_wrap > 0; }

  /** The skin without what stands around it. */
  bodyTriangles() {
    return this.skinTriangles().subarray(0, 3 * (this.head.num_body_triangles ?? Infinity));
  }

  skinTriangles() {
    return Uint32Array.from(this.tables.skin_triangles, (v) => this.tables.skin_points[v]);
  }

  /** Six point indices a prism, outer triangle first: the muscle layer, then the fat layer. */
  get prisms() {
    if (!this.prismTable) {
      const wraps = [0, 1, 2].map((wrap) => this.wrapTriangles(wrap));
      const count = wraps[0].length / 3;
      this.prismTable = new Uint32Array(12 * count);
      for (let layer = 0; layer < 2; ++layer)
        for (let t = 0; t < count; ++t)
          for (let k = 0; k < 3; ++k) {
            this.prismTable[6 * (layer * count + t) + k] = wraps[layer + 1][3 * t + k];
            this.prismTable[6 * (layer * count + t) + 3 + k] = wraps[layer][3 * t + k];
          }
    }
    return this.prismTable;
  }
}

/** Where the points of a body are, x y z and one value of a field each: at rest or in a frame of a method. */
export class Shape {
  constructor(recording) {
    this.recording = recording;
    this.points = new Float32Array(4 * recording.numPoints);
    this.normals = new Float32Array(4 * recording.numPoints);
    this.motions = new Float32Array(8 * recording.head.num_motions);
    this.origin = [0, 0, 0];
    this.frame = null;
  }

  static atRest(recording) {
    const shape = new Shape(recording);
    shape.place(recording.tables.rest, 0, recording.head.rest_origin);
    for (let m = 0; m < recording.head.num_motions; ++m) shape.motions[8 * m + 3] = 1;
    shape.frame = -1;
    return shape;
  }

  place(values, begin, origin) {
    const { span } = this.recording.head;
    for (let i = 0; i < values.length / 3; ++i)
      for (let k = 0; k < 3; ++k)
        this.points[4 * (begin + i) + k] = ((2 * values[3 * i + k]) / 65535 - 1) * span + origin[k];
  }

  /** Moves the points to a frame that has arrived. */
  setFrame(frame, method) {
    if (this.frame === frame && this.method === method) return;
    const { recording } = this;
    this.origin = recording.head.origins[frame];
    this.place(recording.common[frame], 0, this.origin);
    this.place(recording.methods[method][frame], recording.head.num_common, this.origin);
    const motions = recording.motions[frame];
    for (let m = 0; m < recording.head.num_motions; ++m)
      for (let k = 0; k < 7; ++k) this.motions[8 * m + k] = motions[7 * m + k];
    this.frame = frame;
    this.method = method;
  }

  /** Normals of the skin and of the two wraps below it, area-weighted; the skin wrap has those of the skin. */
  updateNormals() {
    const { recording, points, normals } = this;
    this.surfaces ??= [recording.skinTriangles(), recording.wrapTriangles(1), recording.wrapTriangles(0)];
    normals.fill(0);
    for (const triangles of this.surfaces) addNormals(points, triangles, normals);
    for (let i = 0; i < normals.length; i += 4) {
      const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
      for (let k = 0; k < 3; ++k) normals[i + k] /= length;
    }
  }

  point(i) { return [this.points[4 * i], this.points[4 * i + 1], this.points[4 * i + 2]]; }

  /** Rotation and translation of a bone, of a point. */
  moved(motion, x, y, z) {
    const q = this.motions, o = 8 * motion;
    const [a, b, c, w] = [q[o], q[o + 1], q[o + 2], q[o + 3]];
    const tx = 2 * (b * z - c * y), ty = 2 * (c * x - a * z), tz = 2 * (a * y - b * x);
    return [x + w * tx + b * tz - c * ty + q[o + 4], y + w * ty + c * tx - a * tz + q[o + 5],
      z + w * tz + a * ty - b * tx + q[o + 6]];
  }
}

/** Adds the area vectors of triangles to the vertices; both arrays have four numbers a vertex. */
export function addNormals(points, triangles, normals, stride = 4) {
  for (let t = 0; t < triangles.length; t += 3) {
    const a = stride * triangles[t], b = stride * triangles[t + 1], c = stride * triangles[t + 2];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const i of [a, b, c]) {
      normals[i] += nx;
      normals[i + 1] += ny;
      normals[i + 2] += nz;
    }
  }
}

/** Six times the signed volume of the tetrahedron (origin, a, b, c). */
function tetrahedron(p, a, b, c) {
  return p[a] * (p[b + 1] * p[c + 2] - p[b + 2] * p[c + 1]) + p[a + 1] * (p[b + 2] * p[c] - p[b] * p[c + 2])
    + p[a + 2] * (p[b] * p[c + 1] - p[b + 1] * p[c]);
}

/** Volume in a closed surface, m^3. */
export function enclosedVolume(points, triangles, stride = 4) {
  let sum = 0;
  for (let t = 0; t < triangles.length; t += 3)
    sum += tetrahedron(points, stride * triangles[t], stride * triangles[t + 1], stride * triangles[t + 2]);
  return sum / 6;
}

const corners = new Float64Array(18);

/** Exact volume of a prism, m^3: a bilinear side encloses the mean of what its two triangulations do. */
export function prismVolume(points, prisms, p) {
  const c = corners;
  // From the first corner, so that nothing is lost where the body is far from the world's origin.
  for (let k = 0; k < 6; ++k)
    for (let d = 0; d < 3; ++d)
      c[3 * k + d] = points[4 * prisms[6 * p + k] + d] - points[4 * prisms[6 * p] + d];
  let sum = tetrahedron(c, 0, 3, 6) + tetrahedron(c, 9, 15, 12);
  for (const [i, j, k, l] of prismSides) {
    const [a, b, e, f] = [3 * i, 3 * j, 3 * k, 3 * l];
    sum += (tetrahedron(c, a, b, e) + tetrahedron(c, a, e, f) + tetrahedron(c, a, b, f) + tetrahedron(c, b, e, f)) / 2;
  }
  return sum / 6;
}
