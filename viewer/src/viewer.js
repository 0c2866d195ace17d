// SPDX-License-Identifier: Apache-2.0
// The state of a page and what can be done with it, whoever asks: panel, keys, pointer, link.
import { PerspectiveCamera, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Anatomy } from './anatomy.js';
import { Fields, fields } from './fields.js';
import { layers } from './layers.js';
import { pick, pickedPoint } from './pick.js';
import { Recording, Shape, enclosedVolume } from './recording.js';
import { ShapeTextures, Stage } from './stage.js';

const axes = { side: [1, 0, 0], height: [0, 1, 0], depth: [0, 0, 1] };
export const cutKinds = { none: 'None', side: 'Left to right', height: 'Up and down', depth: 'Front to back', view: 'Facing this view' };

export class Viewer extends EventTarget {
  constructor(head, canvas) {
    super();
    this.recording = new Recording(head);
    this.canvas = canvas;
    this.stage = new Stage(canvas);
    this.camera = new PerspectiveCamera(30, 1, 0.05, 40);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.changed());
    this.controls.minDistance = 0.15;
    this.controls.maxDistance = 15;
    this.layers = Object.fromEntries(layers.map((l) => [l.id, { shown: l.shown !== false, opacity: l.opacity }]));
    this.methods = head.methods.length > 1 ? [0, 1] : [0];
    this.frame = 0;
    this.speed = 1;
    this.colour = 'tissue';
    this.range = null;  // the field's own
    this.cut = { kind: 'none', offset: 0, flipped: false, normal: [0, 0, -1] };
    this.selected = null;  // {layer, part}
    this.others = 'shown';
    this.hiddenParts = new Set();  // "layer/index"
    this.marks = [];
    this.anatomy = {};
    this.bodies = [];
    this.times = { opened: performance.now(), firstPicture: null, complete: null };
    this.finePixelRatio = 2;
  }

  changed(what = 'view') {
    this.needsPicture = true;
    this.lastChange = performance.now();
    this.dispatchEvent(new CustomEvent(what));
  }

  /** Takes a decoded block; shows what can be shown. */
  add(block, values) {
    this.recording.add(block, values);
    if (this.recording.ready && !this.rest) {
      this.rest = Shape.atRest(this.recording);
      this.fields = new Fields(this.recording, this.rest);
      this.stage.addSurfaces(this.recording);
      this.bodies = [0, 1].map(() => new ShapeTextures(new Shape(this.recording)));
      this.lookFrom('front');
      this.dispatchEvent(new CustomEvent('ready'));
    }
    for (const layer of ['bone', 'muscle'])
      if (block.name === `${layer}_triangles` && this.recording.head[`${layer}s`].length > 0) {
        this.anatomy[`${layer}s`] = new Anatomy(this.recording, layer, this.recording.head[`${layer}s`], this.rest);
        this.stage.addAnatomy(`${layer}s`, this.anatomy[`${layer}s`]);
        this.updateParts();
      }
    if (this.rest) this.changed('loaded');
  }

  get numLoaded() { return this.recording.numLoaded; }
  get numFrames() { return this.recording.numFrames; }
  get isComplete() { return this.numLoaded === this.numFrames; }

  // -- time
  setFrame(frame) {
    this.frame = Math.max(0, Math.min(this.numFrames - 1, Math.round(frame)));
    this.changed('frame');
  }
  play(on = !this.playing) {
    this.playing = on && this.numFrames > 1;
    this.clock = null;
    this.changed('play');
  }
  /** Called for every picture of the browser; `now` in ms. */
  tick(now) {
    if (this.playing) {
      if (this.clock === null) Object.assign(this, { clock: now, clockFrame: this.frame });
      const passed = ((now - this.clock) / 1000) * this.recording.head.frame_rate * this.speed;
      const frame = (this.clockFrame + Math.floor(passed)) % this.numFrames;
      if (frame !== this.frame && frame < this.numLoaded) this.setFrame(frame);
    }
    this.controls.update();
    if (!this.rest) return;
    const resting = !this.playing && now - this.lastChange > 150;
    if (!this.needsPicture && !(resting && !this.isFine)) return;
    this.needsPicture = false;
    this.isFine = resting;
    this.render();
    if (this.times.firstPicture === null) this.times.firstPicture = performance.now() - this.times.opened;
  }

  // -- what is shown
  setLayer(id, change) {
    Object.assign(this.layers[id], change);
    this.changed('layers');
  }
  setMethods(first, second) {
    const known = (m) => Number.isInteger(m) && m >= 0 && m < this.recording.head.methods.length;
    this.methods = known(second) ? [known(first) ? first : 0, second] : [known(first) ? first : 0];
    this.changed('methods');
  }
  setColour(colour, range = null) {
    if (!fields[colour]) return;
    this.colour = colour;
    this.range = range;
    this.changed('colour');
  }
  get field() {
    const field = fields[this.colour];
    if (!field.ramp) return null;
    const high = (this.range ?? field.range);
    return { ...field, colours: field.ramp, low: field.low * high / field.scale, high: high / field.scale, shownHigh: high, shownLow: field.low * high };
  }
  setCut(change) {
    if (change.kind && !cutKinds[change.kind]) return;
    if (change.kind === 'view' && !change.normal) {
      const ahead = new Vector3();
      this.camera.getWorldDirection(ahead);
      change.normal = ahead.toArray();
    }
    Object.assign(this.cut, change);
    this.changed('cut');
  }
  /** The plane in a frame: it goes with the body. Null for none. */
  planeAt(origin) {
    const { kind, offset, flipped } = this.cut;
    if (kind === 'none') return null;
    const sign = flipped ? -1 : 1;
    // What is nearer to the front, top or left is taken away, so that a view from there looks onto the cut.
    const normal = (kind === 'view' ? this.cut.normal : axes[kind].map((v) => -v)).map((v) => sign * v);
    const along = kind === 'view' ? 1 : -1;
    return { normal, offset: normal[0] * origin[0] + normal[1] * origin[1] + normal[2] * origin[2] + sign * along * offset };
  }

  // -- parts
  get parts() {
    this.partList ??= ['bones', 'muscles'].flatMap((layer) => this.recording.head[layer].map((part, index) => ({ ...part, layer, index })));
    return this.partList;
  }
  partOf(name) { return this.parts.find((part) => part.name === name) ?? null; }
  select(layer, index) {
    this.selected = layer === null ? null : { layer, part: index };
    if (this.selected) {
      this.hiddenParts.delete(`${layer}/${index}`);
      this.layers[layer].shown = true;
    } else this.others = 'shown';
    this.updateParts();
  }
  get selectedPart() {
    return this.selected && this.parts.find((part) => part.layer === this.selected.layer && part.index === this.selected.part);
  }
  /** What happens to all parts but the selected one: "shown", "ghost" or "hidden". */
  setOthers(others) {
    this.others = this.selected && ['ghost', 'hidden'].includes(others) ? others : 'shown';
    this.updateParts();
  }
  hideSelected() {
    if (!this.selected) return;
    this.hiddenParts.add(`${this.selected.layer}/${this.selected.part}`);
    this.select(null);
  }
  showAllParts() {
    this.hiddenParts.clear();
    this.others = 'shown';
    this.updateParts();
  }
  partState(layer, index) {
    if (this.selected?.layer === layer && this.selected.part === index) return this.others === 'shown' ? 3 : 1;
    if (this.hiddenParts.has(`${layer}/${index}`)) return 0;
    return { shown: 1, ghost: 2, hidden: 0 }[this.others];
  }
  updateParts() {
    for (const [id, anatomy] of Object.entries(this.anatomy))
      this.stage.setPartStates(id, anatomy.parts.map((_, p) => this.partState(id, p)));
    this.changed('parts');
  }
  /** Opacity of each layer as drawn: isolating a part leaves nothing else, ghosting it veils what is around. */
  get opacities() {
    const isolating = this.selected && this.others !== 'shown';
    return Object.fromEntries(layers.map(({ id, anatomy }) => {
      const { shown, opacity } = this.layers[id];
      if (!shown || (isolating && !anatomy && this.others === 'hidden')) return [id, 0];
      if (isolating && anatomy) return [id, 1];
      if (isolating) return [id, Math.min(opacity, id === 'skin' ? 0.12 : 0)];
      return [id, opacity];
    }));
  }

  // -- measuring
  shapeOf(slot) { return this.bodies[slot].shape; }
  /** Volume now and at rest in m^3 of "skin", "fat", "muscle_wrap" (its layer), or of the selected part. */
  volumeOf(what, slot = 0) {
    const shape = this.shapeOf(slot);
    if (what === 'fat') return [this.fields.layerVolume(1, shape), this.fields.layerVolume(1)];
    if (what === 'muscle_wrap') return [this.fields.layerVolume(0, shape), this.fields.layerVolume(0)];
    if (what === 'skin') {
      this.skinTriangles ??= this.recording.bodyTriangles();
      return [shape, this.rest].map((s) => enclosedVolume(s.points, this.skinTriangles));
    }
    const anatomy = this.selected && this.anatomy[this.selected.layer];
    return anatomy ? [shape, this.rest].map((s) => anatomy.partVolume(this.selected.part, s)) : null;
  }
  /** Marks a picked point; a third one begins anew. */
  mark(found) {
    this.marks = this.marks.length >= 2 ? [found] : [...this.marks, found];
    this.changed('marks');
  }
  markPoints(slot) {
    return this.marks.map((found) => pickedPoint(found, this.shapeOf(slot), this.anatomy[found.id]));
  }
  /** Metres between the two marks, null without. */
  distance(slot = 0) {
    if (this.marks.length < 2) return null;
    const [a, b] = this.markPoints(slot);
    return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }

  // -- camera
  /** Shows the whole body as it is in this frame. */
  lookFrom(side) {
    const ahead = new Vector3(...{ front: [0, 0.05, 1], back: [0, 0.05, -1], left: [1, 0.05, 0], right: [-1, 0.05, 0], above: [0, 1, 0.01] }[side]).normalize();
    const { low, high } = this.bounds();
    const across = side === 'left' || side === 'right' ? high[2] - low[2] : high[0] - low[0];
    const up = side === 'above' ? high[2] - low[2] : high[1] - low[1];
    const deep = side === 'above' ? high[1] - low[1] : side === 'left' || side === 'right' ? high[0] - low[0] : high[2] - low[2];
    const box = this.boxes[0];
    const half = 1.14 * Math.max(up, across / (box.width / box.height)) / 2;
    this.controls.target.set(...low.map((v, k) => (v + high[k]) / 2));
    this.camera.position.copy(ahead).multiplyScalar(half / Math.tan(this.camera.fov * Math.PI / 360) + deep / 2).add(this.controls.target);
    const origin = this.recording.head.origins[this.frame];
    this.followed = [origin[0], origin[2]];
    this.changed();
  }
  /** Corners of the box around the body, m. */
  bounds() {
    const { points } = this.prepare(0).shape, low = [9, 9, 9], high = [-9, -9, -9], [x, , z] = this.shapeOf(0).origin;
    for (let i = 0; i < points.length; i += 4)
      for (let k = 0; k < 3; ++k) {
        const from = [x, 0, z][k];
        low[k] = Math.min(low[k], points[i + k] - from);
        high[k] = Math.max(high[k], points[i + k] - from);
      }
    return { low: [low[0] + x, low[1], low[2] + z], high: [high[0] + x, high[1], high[2] + z] };
  }
  /** The camera goes with the body over ground. */
  follow() {
    const origin = this.recording.head.origins[this.frame];
    this.followed ??= [origin[0], origin[2]];
    const [dx, dz] = [origin[0] - this.followed[0], origin[2] - this.followed[1]];
    this.camera.position.x += dx;
    this.controls.target.x += dx;
    this.camera.position.z += dz;
    this.controls.target.z += dz;
    this.followed = [origin[0], origin[2]];
  }
  turn(angle) {
    this.camera.position.sub(this.controls.target).applyAxisAngle(new Vector3(0, 1, 0), angle).add(this.controls.target);
    this.changed();
  }
  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.changed();
  }

  // -- pictures
  /** Where each body is drawn, CSS pixels from the lower left. */
  get boxes() {
    const { width, height } = this;
    if (this.methods.length < 2) return [{ x: 0, y: 0, width, height }];
    if (width >= height) return [0, 1].map((k) => ({ x: Math.round(k * width / 2), y: 0, width: Math.round(width / 2), height }));
    return [1, 0].map((k) => ({ x: 0, y: Math.round(k * height / 2), width, height: Math.round(height / 2) }));
  }
  resize(width, height, pixelRatio) {
    if (width < 1 || height < 1) return;
    Object.assign(this, { width, height, pixelRatio });
    this.changed();
  }
  prepare(slot) {
    const body = this.bodies[slot], { shape } = body, frame = Math.min(this.frame, this.numLoaded - 1);
    const key = `${frame}/${this.methods[slot]}/${this.colour}`;
    if (body.key === key) return body;
    shape.setFrame(frame, this.methods[slot]);
    this.fields.apply(this.colour, shape);
    body.update();
    body.key = key;
    return body;
  }
  render() {
    this.follow();
    // Edges are smooth in pictures that stand: two pixels each way for one of the screen. (Multisampling is not used:
    // software renderers let triangles seen edge on shine through others there.)
    const pixelRatio = this.isFine ? this.finePixelRatio : Math.min(2, this.pixelRatio);
    this.stage.resize(this.width, this.height, pixelRatio);
    this.stage.setField(this.field);
    const boxes = this.boxes;
    boxes.forEach((box, slot) => {
      const body = this.prepare(slot);
      this.camera.aspect = box.width / box.height;
      this.camera.updateProjectionMatrix();
      this.camera.updateMatrixWorld();
      this.stage.setCut(this.planeAt(body.shape.origin));
      this.stage.render(body, this.camera, this.opacities, box, this.selected);
    });
    this.dispatchEvent(new CustomEvent('rendered'));
  }
  /** Promise of a PNG of the picture. */
  png() {
    this.isFine = true;
    this.render();
    return new Promise((resolve) => { this.canvas.toBlob(resolve, 'image/png'); });
  }

  // -- pointer
  slotAt(x, y) {
    return Math.max(0, this.boxes.findIndex((b) => x >= b.x && x < b.x + b.width && this.height - y >= b.y && this.height - y < b.y + b.height));
  }
  /** What is under a place of the canvas, CSS pixels from the upper left; null for nothing. */
  pickAt(x, y) {
    if (!this.rest) return null;
    const slot = this.slotAt(x, y), box = this.boxes[slot], { shape } = this.prepare(slot);
    this.camera.aspect = box.width / box.height;
    this.camera.updateProjectionMatrix();
    const far = new Vector3(2 * (x - box.x) / box.width - 1, 2 * (this.height - y - box.y) / box.height - 1, 0.5).unproject(this.camera);
    const origin = this.camera.position.toArray(), ray = far.sub(this.camera.position).normalize().toArray();
    const opacities = this.opacities;
    const surfaces = layers.filter(({ id }) => opacities[id] > 0 && this.stage.meshes[id]).map(({ id }) => {
      const anatomy = this.anatomy[id];
      const common = { id, solid: opacities[id] > 0.5 };
      if (!anatomy)
        return { ...common, positions: shape.points, stride: 4, triangles: this.stage.meshes[id].geometry.index.array, partOf: () => null, isShown: () => true };
      const key = `${shape.frame}/${shape.method}`;
      anatomy.cache ??= [];
      if (anatomy.cache[slot]?.key !== key) anatomy.cache[slot] = { key, positions: anatomy.evaluate(shape) };
      return { ...common, positions: anatomy.cache[slot].positions, stride: 3, triangles: anatomy.triangles,
        partOf: (t) => anatomy.partOfVertex[anatomy.triangles[t]], isShown: (p) => [1, 3].includes(this.partState(id, p)) };
    });
    return pick(origin, ray, surfaces, this.planeAt(shape.origin));
  }
  /** A point as CSS pixels of the canvas, for the marks. */
  project(point, slot) {
    const box = this.boxes[slot];
    this.camera.aspect = box.width / box.height;
    this.camera.updateProjectionMatrix();
    const at = new Vector3(...point).project(this.camera);
    return [box.x + (at.x + 1) / 2 * box.width, this.height - box.y - (at.y + 1) / 2 * box.height];
  }

  /** Everything a link holds, and what tests look at. */
  state() {
    return {
      frame: this.frame, numFrames: this.numFrames, numLoaded: this.numLoaded, playing: !!this.playing,
      methods: [...this.methods], layers: structuredClone(this.layers), colour: this.colour, range: this.range ?? undefined,
      cut: { ...this.cut }, selected: this.selectedPart?.name ?? null, others: this.others,
      hidden: [...this.hiddenParts], camera: this.camera.position.toArray(), target: this.controls.target.toArray(),
      distance: this.distance(), times: { ...this.times },
    };
  }
  /** Takes what fromLink() found. */
  restore(link) {
    if (link.layers) for (const [id, layer] of Object.entries(link.layers)) if (this.layers[id]) Object.assign(this.layers[id], layer);
    if (link.methods) this.setMethods(...link.methods);
    if (link.colour) this.setColour(link.colour, link.range ?? null);
    if (link.cut) this.setCut(link.cut);
    if (link.frame !== undefined) this.setFrame(link.frame);
    if (link.hidden) this.hiddenParts = new Set(link.hidden);
    const part = link.part && this.partOf(link.part);
    if (part) {
      this.select(part.layer, part.index);
      this.setOthers(link.others);
    } else this.updateParts();
    if (link.camera) {
      this.camera.position.set(...link.camera);
      this.controls.target.set(...link.target);
      const origin = this.recording.head.origins[this.frame];
      this.followed = [origin[0], origin[2]];
    }
    this.changed();
  }
}
