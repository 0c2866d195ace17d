// SPDX-License-Identifier: Apache-2.0
// What lies under the pointer, and points that stay where they were put on a deforming surface.

/** Distance along the ray to a triangle and the barycentric coordinates there, or null (Moeller and Trumbore 1997). */
function hitTriangle(origin, ray, p, a, b, c) {
  const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
  const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
  const hx = ray[1] * vz - ray[2] * vy, hy = ray[2] * vx - ray[0] * vz, hz = ray[0] * vy - ray[1] * vx;
  const det = ux * hx + uy * hy + uz * hz;
  if (Math.abs(det) < 1e-14) return null;
  const sx = origin[0] - p[a], sy = origin[1] - p[a + 1], sz = origin[2] - p[a + 2];
  const s = (sx * hx + sy * hy + sz * hz) / det;
  if (s < 0 || s > 1) return null;
  const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
  const t = (ray[0] * qx + ray[1] * qy + ray[2] * qz) / det;
  if (t < 0 || s + t > 1) return null;
  const distance = (vx * qx + vy * qy + vz * qz) / det;
  return distance > 0 ? { distance, weights: [1 - s - t, s, t] } : null;
}

/**
 * The nearest surface on a ray. `surfaces`: {id, positions, stride, triangles, solid, partOf, isShown}: partOf(triangle)
 * tells its part, isShown(part) whether it counts. What is see-through counts only where nothing solid is hit.
 * Returns {id, part, corners, weights, distance} or null.
 */
export function pick(origin, ray, surfaces, cut) {
  let best = null, through = null;
  for (const surface of surfaces) {
    const { positions, stride, triangles } = surface;
    for (let t = 0; t < triangles.length; t += 3) {
      const hit = hitTriangle(origin, ray, positions, stride * triangles[t], stride * triangles[t + 1], stride * triangles[t + 2]);
      if (!hit) continue;
      const held = surface.solid ? best : through;
      if (held && held.distance <= hit.distance) continue;
      if (cut) {
        const at = ray.reduce((sum, r, k) => sum + cut.normal[k] * (origin[k] + hit.distance * r), 0);
        if (at < cut.offset) continue;
      }
      const part = surface.partOf(t);
      if (!surface.isShown(part)) continue;
      const found = { ...hit, id: surface.id, part, corners: [triangles[t], triangles[t + 1], triangles[t + 2]] };
      if (surface.solid) best = found;
      else through = found;
    }
  }
  return best ?? through;
}

/** Where a picked point is in a shape. `anatomy`: of the layer it lies on, if it is bones or muscles. */
export function pickedPoint(found, shape, anatomy) {
  let positions = shape.points, stride = 4;
  if (anatomy) {
    positions = new Float32Array(3 * anatomy.numVertices);
    for (const v of found.corners) anatomy.evaluate(shape, positions, v, v + 1);
    stride = 3;
  }
  return [0, 1, 2].map((k) => found.corners.reduce((sum, v, i) => sum + found.weights[i] * positions[stride * v + k], 0));
}
