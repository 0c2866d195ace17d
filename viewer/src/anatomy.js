// SPDX-License-Identifier: Apache-2.0
// Bones or muscles: their parts, and where their vertices are (lib/ndg/page/carried_anatomy.h has the formula).
import { addNormals, enclosedVolume } from './recording.js';

export class Anatomy {
  /** `layer`: "bone" or "muscle", of which all tables have arrived; `parts`: from the head; `rest`: the body at rest. */
  constructor(recording, layer, parts, rest) {
    const { head, tables } = recording;
    const table = (name) => tables[`${layer}_${name}`];
    this.layer = layer;
    this.parts = parts;
    this.numVertices = table('motions').length;
    this.rest = Float32Array.from(table('rest'), (v, i) => (2 * v / 65535 - 1) * head.span + head.rest_origin[i % 3]);
    this.motions = table('motions');
    this.shares = Float32Array.from(table('shares'), (v) => v / 65535);
    this.carriers = table('carriers');
    this.weights = Float32Array.from(new Int16Array(table('weights').buffer), (v) => v / head.weight_unit);
    for (let i = 0; i < this.weights.length; i += 6) {
      let sum = 0;
      for (let k = 0; k < 6; ++k) sum += this.weights[i + k];
      if (sum > 0) for (let k = 0; k < 6; ++k) this.weights[i + k] /= sum;
    }
    this.triangles = Uint32Array.from(table('triangles'));
    this.partOfVertex = new Uint16Array(this.numVertices);
    parts.forEach((part, p) => {
      this.partOfVertex.fill(p, part.vertices[0], part.vertices[1]);
      for (let i = 3 * part.triangles[0]; i < 3 * part.triangles[1]; ++i) this.triangles[i] += part.vertices[0];
    });
    const firstStored = head.num_common + 2 * head.num_wrap;
    this.isStored = (v) => this.carriers[6 * v] >= firstStored;
    this.restNormals = this.normalsAt(this.evaluate(rest));
    this.dualNormals = this.dualsAt(rest);
  }

  /** Positions of the vertices [begin, end) in a shape, x y z each, into an array for all vertices. */
  evaluate(shape, out = new Float32Array(3 * this.numVertices), begin = 0, end = this.numVertices) {
    const { points } = shape, { weights, carriers, rest } = this;
    for (let v = begin; v < end; ++v) {
      const share = this.shares[v];
      let x = 0, y = 0, z = 0;
      if (share < 1)
        for (let k = 6 * v; k < 6 * v + 6; ++k) {
          const weight = weights[k], at = 4 * carriers[k];
          if (weight === 0) continue;
          x += weight * points[at];
          y += weight * points[at + 1];
          z += weight * points[at + 2];
        }
      if (share > 0) {
        const moved = shape.moved(this.motions[v], rest[3 * v], rest[3 * v + 1], rest[3 * v + 2]);
        x += share * (moved[0] - x);
        y += share * (moved[1] - y);
        z += share * (moved[2] - z);
      }
      out[3 * v] = x;
      out[3 * v + 1] = y;
      out[3 * v + 2] = z;
    }
    return out;
  }

  normalsAt(positions) {
    const normals = new Float32Array(3 * this.numVertices);
    addNormals(positions, this.triangles, normals, 3);
    for (let i = 0; i < normals.length; i += 3) {
      const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
      for (let k = 0; k < 3; ++k) normals[i + k] /= length;
    }
    return normals;
  }

  /**
   * Normals at rest in the dual basis of three edges of the element that carries a vertex. A normal moves with the
   * cofactor of the deformation gradient: the same numbers times the cross products of the moved edges. Zero for
   * vertices that no element carries.
   */
  dualsAt(rest) {
    const duals = new Float32Array(3 * this.numVertices);
    const edges = [[], [], []];
    for (let v = 0; v < this.numVertices; ++v) {
      if (this.shares[v] === 1 || this.isStored(v)) continue;
      const origin = rest.point(this.carriers[6 * v]);
      for (let e = 0; e < 3; ++e) {
        const tip = rest.point(this.carriers[6 * v + 1 + e]);
        for (let k = 0; k < 3; ++k) edges[e][k] = tip[k] - origin[k];
      }
      const [a, b, c] = edges;
      const volume = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
      // In units of the element's size, so that shares of the two normals can be blended.
      const scale = Math.sign(volume) / (Math.abs(volume) || 1);
      for (let e = 0; e < 3; ++e)
        for (let k = 0; k < 3; ++k) duals[3 * v + e] += scale * edges[e][k] * this.restNormals[3 * v + k];
    }
    return duals;
  }

  trianglesOf(p) {
    const [begin, end] = this.parts[p].triangles;
    return this.triangles.subarray(3 * begin, 3 * end);
  }

  /** m^3. */
  partVolume(p, shape) {
    this.scratch ??= new Float32Array(3 * this.numVertices);
    const [begin, end] = this.parts[p].vertices;
    return enclosedVolume(this.evaluate(shape, this.scratch, begin, end), this.trianglesOf(p), 3);
  }
}
