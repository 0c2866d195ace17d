// SPDX-License-Identifier: Apache-2.0
// The picture: layers as meshes whose vertices a texture moves, translucent ones last, and the cut of a plane filled.
import {
  AlwaysStencilFunc, BackSide, BufferAttribute, BufferGeometry, Color, DataTexture, DecrementWrapStencilOp, DoubleSide,
  FloatType, FrontSide, GLSL3, IncrementWrapStencilOp, IntType, KeepStencilOp, LinearFilter, Matrix4, Mesh,
  NotEqualStencilFunc, PlaneGeometry, Quaternion, RawShaderMaterial, RGBAFormat, Scene, UnsignedByteType, Vector3,
  Vector4, WebGLRenderer,
} from 'three';
import { cutOrder, highlightColour, layers } from './layers.js';
import { anatomyVertex, capFragment, capVertex, fragment, surfaceVertex } from './shaders.js';

const textureWidth = 256;
const skinThickness = 0.0016;  // m, drawn between skin and fat, which share a surface

function floatTexture(data, width) {
  const texture = new DataTexture(data, width, data.length / 4 / width, RGBAFormat, FloatType);
  texture.needsUpdate = true;
  return texture;
}

/** Textures of one body shown: points, normals and motions of a Shape. */
export class ShapeTextures {
  constructor(shape) {
    const size = 4 * textureWidth * Math.ceil(shape.points.length / 4 / textureWidth);
    this.shape = shape;
    this.points = floatTexture(new Float32Array(size), textureWidth);
    this.normals = floatTexture(new Float32Array(size), textureWidth);
    this.motions = floatTexture(shape.motions, shape.motions.length / 4);
  }

  update() {
    this.shape.updateNormals();
    this.points.image.data.set(this.shape.points);
    this.normals.image.data.set(this.shape.normals);
    for (const texture of [this.points, this.normals, this.motions]) texture.needsUpdate = true;
  }
}

function attribute(array, size, integer = false) {
  const result = new BufferAttribute(array, size);
  if (integer) result.gpuType = IntType;
  return result;
}

/** Triangles that close the holes of a surface, each a fan over the hole's border: only counting needs them. */
function holeTriangles(triangles) {
  const next = new Map();
  const edges = new Set();
  for (let t = 0; t < triangles.length; t += 3)
    for (let k = 0; k < 3; ++k) edges.add(triangles[t + k] * 65536 + triangles[t + (k + 1) % 3]);
  for (const edge of edges) {
    const from = Math.floor(edge / 65536), to = edge % 65536;
    if (!edges.has(to * 65536 + from)) next.set(to, from);
  }
  const fans = [];
  while (next.size > 0) {
    const [start] = next.keys();
    const loop = [];
    for (let at = start; next.has(at);) {
      loop.push(at);
      const after = next.get(at);
      next.delete(at);
      at = after;
    }
    for (let i = 1; i + 1 < loop.length; ++i) fans.push(loop[0], loop[i], loop[i + 1]);
  }
  return fans;
}

export class Stage {
  constructor(canvas) {
    this.renderer = new WebGLRenderer({ canvas, antialias: false, stencil: true, preserveDrawingBuffer: false });
    this.renderer.autoClear = false;
    this.meshes = {};
    this.solids = {};
    this.uniforms = {
      points: { value: null }, normals: { value: null }, motions: { value: null },
      plane: { value: new Vector4(0, 0, 0, 1) }, byField: { value: false }, fieldRange: { value: [0, 1] },
      ramp: { value: null }, highlight: { value: new Color(highlightColour) },
    };
    this.background = new Color('#f3f2ef');
    this.placeOfCut = new Matrix4();
    this.cutMaterials = {};
    this.scene = new Scene();  // holds one mesh at a time: the order of passes is ours
    this.scene.matrixWorldAutoUpdate = false;
    this.cut = this.makeCut();
  }

  /** Wraps and skin, of which topology and rest have arrived. */
  addSurfaces(recording) {
    const wrap = (k) => recording.wrapTriangles(k);
    for (const [id, triangles, closed] of [['skin', recording.skinTriangles(), null], ['fat', wrap(2), holeTriangles(wrap(2))],
      ['muscle_wrap', wrap(1), holeTriangles(wrap(1))], ['bone_wrap', wrap(0), holeTriangles(wrap(0))]]) {
      const geometry = (list) => {
        const result = new BufferGeometry();
        result.setAttribute('point', attribute(Uint16Array.from({ length: recording.numPoints }, (_, i) => i), 1, true));
        result.setIndex(new BufferAttribute(Uint32Array.from(list), 1));
        return result;
      };
      this.addLayer(id, geometry(triangles), closed ? geometry([...triangles, ...closed]) : null);
    }
    this.meshes.fat.userData.own.inset.value = skinThickness;
  }

  /** Bones or muscles. */
  addAnatomy(id, anatomy) {
    const count = anatomy.numVertices;
    const columns = (source, from, size, Type) =>
      Type.from({ length: size * count }, (_, i) => source[6 * Math.floor(i / size) + from + i % size]);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', attribute(anatomy.rest, 3));
    geometry.setAttribute('normal', attribute(anatomy.restNormals, 3));
    geometry.setAttribute('dual', attribute(anatomy.dualNormals, 3));
    geometry.setAttribute('carriersA', attribute(columns(anatomy.carriers, 0, 4, Uint16Array), 4, true));
    geometry.setAttribute('carriersB', attribute(columns(anatomy.carriers, 4, 2, Uint16Array), 2, true));
    geometry.setAttribute('weightsA', attribute(columns(anatomy.weights, 0, 4, Float32Array), 4));
    geometry.setAttribute('weightsB', attribute(columns(anatomy.weights, 4, 2, Float32Array), 2));
    geometry.setAttribute('share', attribute(anatomy.shares, 1));
    geometry.setAttribute('motionAndPart', attribute(Uint16Array.from({ length: 2 * count },
      (_, i) => (i % 2 ? anatomy.partOfVertex : anatomy.motions)[i >> 1]), 2, true));
    geometry.setIndex(new BufferAttribute(anatomy.triangles, 1));
    const states = new DataTexture(new Uint8Array(4 * anatomy.parts.length), anatomy.parts.length, 1, RGBAFormat, UnsignedByteType);
    this.addLayer(id, geometry, null, states);
  }

  addLayer(id, geometry, solidGeometry, parts) {
    const layer = layers.find((entry) => entry.id === id);
    const own = {
      tissue: { value: new Color(layer.colour) }, gloss: { value: layer.gloss }, opacity: { value: 1 },
      isAnatomy: { value: !!parts }, parts: { value: parts ?? null }, inset: { value: 0 }, onlyPart: { value: -1 },
    };
    const mesh = this.mesh(geometry, own, parts);
    this.meshes[id] = mesh;
    this.solids[id] = solidGeometry ? this.mesh(solidGeometry, own, parts) : mesh;
    this.cutMaterials[id] = { value: new Color(layer.cut) };
  }

  mesh(geometry, own, parts) {
    const make = (pass, settings) => new RawShaderMaterial({
      glslVersion: GLSL3, vertexShader: parts ? anatomyVertex : surfaceVertex, fragmentShader: fragment,
      uniforms: { ...this.uniforms, ...own, pass: { value: pass } }, ...settings,
    });
    const counting = (side, op) => make(2, {
      side, depthTest: false, depthWrite: false, colorWrite: false, stencilWrite: true, stencilFunc: AlwaysStencilFunc,
      stencilFail: KeepStencilOp, stencilZFail: op, stencilZPass: op,
    });
    const mesh = new Mesh(geometry);
    mesh.frustumCulled = false;
    mesh.userData = {
      own,
      solid: make(0, { side: DoubleSide }),
      depth: make(0, { side: DoubleSide, colorWrite: false }),
      veil: make(0, { side: DoubleSide, transparent: true }),
      ghost: make(1, { side: DoubleSide, transparent: true, depthWrite: false }),
      count: [counting(BackSide, IncrementWrapStencilOp), counting(FrontSide, DecrementWrapStencilOp)],
    };
    return mesh;
  }

  makeCut() {
    const material = new RawShaderMaterial({
      glslVersion: GLSL3, vertexShader: capVertex, fragmentShader: capFragment, side: DoubleSide,
      uniforms: { placed: { value: this.placeOfCut }, tissue: { value: new Color() } },
      stencilWrite: true, stencilFunc: NotEqualStencilFunc, stencilRef: 0, stencilFail: KeepStencilOp,
      stencilZFail: KeepStencilOp, stencilZPass: KeepStencilOp,
    });
    const mesh = new Mesh(new PlaneGeometry(8, 8), material);
    mesh.frustumCulled = false;
    return mesh;
  }

  /** `cut`: {normal, offset}, shown where normal . x >= offset; null for no section. */
  setCut(cut) {
    this.isCut = !!cut;
    this.uniforms.plane.value.set(0, 0, 0, 1);
    if (!cut) return;
    const normal = new Vector3(...cut.normal);
    this.uniforms.plane.value.set(normal.x, normal.y, normal.z, -cut.offset);
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal);
    this.placeOfCut.compose(normal.clone().multiplyScalar(cut.offset), turn, new Vector3(1, 1, 1));
  }

  /** `low`, `high`: values at the ends of the ramp; `colours`: sRGB, evenly spaced. */
  setField(field) {
    this.uniforms.byField.value = !!field;
    if (!field) return;
    this.uniforms.fieldRange.value = [field.low, field.high];
    const texels = new Uint8Array(field.colours.flatMap((c) => [1, 3, 5].map((i) => parseInt(c.slice(i, i + 2), 16)).concat(255)));
    // Sampled from the middle of the first texel to that of the last.
    const fine = new Uint8Array(256 * 4);
    for (let i = 0; i < 256; ++i) {
      const at = (i / 255) * (field.colours.length - 1), left = Math.min(Math.floor(at), field.colours.length - 2);
      for (let k = 0; k < 4; ++k)
        fine[4 * i + k] = texels[4 * left + k] * (1 - at + left) + texels[4 * left + 4 + k] * (at - left);
    }
    const ramp = new DataTexture(fine, 256, 1, RGBAFormat, UnsignedByteType);
    ramp.minFilter = ramp.magFilter = LinearFilter;
    ramp.needsUpdate = true;
    this.uniforms.ramp.value?.dispose();
    this.uniforms.ramp.value = ramp;
  }

  /** One of 0 hidden, 1 shown, 2 ghost, 3 selected for every part of a layer. */
  setPartStates(id, states) {
    const texture = this.meshes[id]?.userData.own.parts.value;
    if (!texture) return;
    states.forEach((state, p) => { texture.image.data[4 * p] = state; });
    texture.needsUpdate = true;
  }

  resize(width, height, pixelRatio) {
    const key = `${width} ${height} ${pixelRatio}`;
    if (this.size === key) return;
    this.size = key;
    this.renderer.setPixelRatio(pixelRatio);
    this.renderer.setSize(width, height, false);
  }

  draw(mesh, material, camera) {
    mesh.material = material;
    material.uniformsNeedUpdate = true;  // the same material may come again with textures of another body
    this.scene.children = [mesh];
    this.renderer.render(this.scene, camera);
  }

  /** Draws a body into a part of the canvas, in CSS pixels from the lower left. `shown`: opacity of each layer, 0 hidden. */
  render(textures, camera, shown, box, selected) {
    const { renderer } = this;
    renderer.setViewport(box.x, box.y, box.width, box.height);
    renderer.setScissor(box.x, box.y, box.width, box.height);
    renderer.setScissorTest(true);
    renderer.setClearColor(this.background, 1);
    renderer.clear();
    for (const name of ['points', 'normals', 'motions']) this.uniforms[name].value = textures[name];
    const visible = layers.filter((layer) => this.meshes[layer.id] && shown[layer.id] > 0);
    for (const layer of visible) this.meshes[layer.id].userData.own.opacity.value = shown[layer.id];
    for (const layer of visible)
      if (shown[layer.id] >= 1) this.draw(this.meshes[layer.id], this.meshes[layer.id].userData.solid, camera);
    if (this.isCut) this.renderCuts(visible, camera, selected);
    for (const layer of [...visible].reverse()) {
      const mesh = this.meshes[layer.id];
      if (shown[layer.id] < 1) {
        // Depth first: of a translucent layer only the front is seen, not its own back through it.
        this.draw(mesh, mesh.userData.depth, camera);
        this.draw(mesh, mesh.userData.veil, camera);
      }
      if (mesh.userData.own.isAnatomy.value) this.draw(mesh, mesh.userData.ghost, camera);
    }
  }

  renderCuts(visible, camera, selected) {
    for (const id of cutOrder)
      if (visible.some((layer) => layer.id === id)) this.renderCut(id, this.cutMaterials[id].value, camera, -1);
    if (selected && visible.some((layer) => layer.id === selected.layer))
      this.renderCut(selected.layer, this.uniforms.highlight.value, camera, selected.part);
  }

  renderCut(id, colour, camera, onlyPart) {
    const mesh = this.solids[id], { own, count } = mesh.userData;
    this.renderer.clearStencil();
    own.onlyPart.value = onlyPart;
    for (const material of count) this.draw(mesh, material, camera);
    own.onlyPart.value = -1;
    this.cut.material.uniforms.tissue.value = colour;
    this.draw(this.cut, this.cut.material, camera);
  }
}
