// SPDX-License-Identifier: Apache-2.0
// Fields that colour the flesh, one value a point of a shape (fourth number of Shape.points).
import { Shape, prismVolume } from './recording.js';

/** Stands for "no value here"; shown grey. */
export const noValue = 1e9;

const diverging = ['#21439a', '#6ba1db', '#e6e3e0', '#ed8763', '#a81221'];
const sequential = ['#e8e4dc', '#f3c766', '#e2793a', '#a92f4a', '#4b1550'];

/**
 * `ramp`: colours from low to high. `range`: value in full colour, in `unit`s; a diverging ramp goes from minus that.
 * `scale`: units in one of the value that is computed.
 */
export const fields = {
  tissue: { label: 'Tissue' },
  volume: { label: 'Volume change', unit: '%', scale: 100, range: 25, ramp: diverging, low: -1,
    about: 'Volume of the flesh against rest: below the skin of both layers, at the wraps and in muscles of the muscle layer' },
  stretch: { label: 'Largest stretch', unit: '%', scale: 100, range: 60, ramp: sequential, low: 0,
    about: 'Largest principal stretch of the flesh less one: below the skin in fat, at the wraps and in muscles in the muscle layer' },
  distance: { label: 'Distance to', unit: 'mm', scale: 1000, range: 10, ramp: sequential, low: 0,
    about: 'How far a point lies from where the first method has it' },
};

/** Sums a value over the prisms at each wrap vertex, of one layer: `numerator(p) / denominator(p)`, each summed. */
function perWrapVertex(recording, layer, numerator, denominator) {
  const triangles = recording.tables.wrap_triangles, count = triangles.length / 3;
  const above = new Float64Array(recording.head.num_wrap), below = new Float64Array(recording.head.num_wrap);
  for (let t = 0; t < count; ++t) {
    const p = layer * count + t, n = numerator(p), d = denominator(p);
    for (let k = 0; k < 3; ++k) {
      above[triangles[3 * t + k]] += n;
      below[triangles[3 * t + k]] += d;
    }
  }
  return { above, below };
}

/** Columns of the element's basis in the middle of a prism, in out[0..8]: x y z of each. */
function middleBasis(points, prisms, p, out) {
  for (let d = 0; d < 3; ++d) {
    const at = (k) => points[4 * prisms[6 * p + k] + d];
    const [a, b, c, e, f, g] = [at(0), at(1), at(2), at(3), at(4), at(5)];
    out[d] = (b - a + f - e) / 2;
    out[3 + d] = (c - a + g - e) / 2;
    out[6 + d] = (a + b + c - e - f - g) / 3;
  }
}

/** Inverses of the bases at rest, row-major, nine numbers a prism. */
function inverseBases(rest, prisms) {
  const inverses = new Float64Array(prisms.length / 6 * 9), m = new Float64Array(9);
  for (let p = 0; p < prisms.length / 6; ++p) {
    middleBasis(rest.points, prisms, p, m);
    for (let row = 0; row < 3; ++row) {
      const u = 3 * ((row + 1) % 3), v = 3 * ((row + 2) % 3);
      for (let d = 0; d < 3; ++d)
        inverses[9 * p + 3 * row + d] = m[u + (d + 1) % 3] * m[v + (d + 2) % 3] - m[u + (d + 2) % 3] * m[v + (d + 1) % 3];
    }
    const i = 9 * p, volume = m[0] * inverses[i] + m[1] * inverses[i + 1] + m[2] * inverses[i + 2];
    for (let k = 0; k < 9; ++k) inverses[i + k] /= volume;
  }
  return inverses;
}

const basis = new Float64Array(9), gradient = new Float64Array(9);

/** Largest principal stretch less one of the deformation gradient in the middle of a prism. */
function largestStretch(inverses, points, prisms, p) {
  middleBasis(points, prisms, p, basis);
  for (let i = 0; i < 3; ++i)
    for (let j = 0; j < 3; ++j)
      gradient[3 * j + i] = basis[i] * inverses[9 * p + j] + basis[3 + i] * inverses[9 * p + 3 + j]
        + basis[6 + i] * inverses[9 * p + 6 + j];
  const dot = (a, b) => gradient[3 * a] * gradient[3 * b] + gradient[3 * a + 1] * gradient[3 * b + 1]
    + gradient[3 * a + 2] * gradient[3 * b + 2];
  return Math.sqrt(largestEigenvalue(dot(0, 0), dot(1, 1), dot(2, 2), dot(0, 1), dot(1, 2), dot(0, 2))) - 1;
}

/** Of a symmetric 3 x 3 matrix, by the cosine of its characteristic angle (Smith 1961). */
export function largestEigenvalue(xx, yy, zz, xy, yz, xz) {
  const mean = (xx + yy + zz) / 3;
  const off = xy * xy + yz * yz + xz * xz;
  const p = Math.sqrt(((xx - mean) ** 2 + (yy - mean) ** 2 + (zz - mean) ** 2 + 2 * off) / 6);
  if (p < 1e-12) return mean;
  const [a, b, c, d, e, g] = [(xx - mean) / p, (yy - mean) / p, (zz - mean) / p, xy / p, yz / p, xz / p];
  const half = (a * (b * c - e * e) - d * (d * c - e * g) + g * (d * e - b * g)) / 2;
  return mean + 2 * p * Math.cos(Math.acos(Math.min(1, Math.max(-1, half))) / 3);
}

export class Fields {
  constructor(recording, rest) {
    this.recording = recording;
    this.rest = rest;
    this.reference = null;
  }

  get restVolumes() {
    this.volumes ??= Float64Array.from({ length: this.recording.prisms.length / 6 },
      (_, p) => prismVolume(this.rest.points, this.recording.prisms, p));
    return this.volumes;
  }

  /** Volume of a layer of flesh, m^3: 0 muscle layer, 1 fat layer. */
  layerVolume(layer, shape) {
    const { prisms } = this.recording, count = prisms.length / 12;
    let sum = 0;
    for (let p = layer * count; p < (layer + 1) * count; ++p)
      sum += shape ? prismVolume(shape.points, prisms, p) : this.restVolumes[p];
    return sum;
  }

  /** Writes a field into the points of a shape. */
  apply(name, shape) {
    const { recording } = this, { points } = shape, n = recording.head.num_wrap;
    for (let i = 3; i < points.length; i += 4) points[i] = noValue;
    const put = (wrap, value) => {
      for (let w = 0, begin = recording.wrapBegin(wrap); w < n; ++w) points[4 * (begin + w) + 3] = value(w);
    };
    if (name === 'volume') {
      const [muscle, fat] = [0, 1].map((layer) => perWrapVertex(recording, layer,
        (p) => prismVolume(points, recording.prisms, p), (p) => this.restVolumes[p]));
      put(2, (w) => (muscle.above[w] + fat.above[w]) / (muscle.below[w] + fat.below[w]) - 1);
      for (const wrap of [0, 1]) put(wrap, (w) => muscle.above[w] / muscle.below[w] - 1);
    } else if (name === 'stretch') {
      this.inverses ??= inverseBases(this.rest, recording.prisms);
      const [muscle, fat] = [0, 1].map((layer) => perWrapVertex(recording, layer,
        (p) => this.restVolumes[p] * largestStretch(this.inverses, points, recording.prisms, p),
        (p) => this.restVolumes[p]));
      put(2, (w) => fat.above[w] / fat.below[w]);
      for (const wrap of [0, 1]) put(wrap, (w) => muscle.above[w] / muscle.below[w]);
    } else if (name === 'distance') {
      this.reference ??= new Shape(recording);
      this.reference.setFrame(shape.frame, 0);
      const other = this.reference.points;
      for (let i = 0; i < points.length; i += 4)
        points[i + 3] = Math.hypot(points[i] - other[i], points[i + 1] - other[i + 1], points[i + 2] - other[i + 2]);
    }
  }
}
