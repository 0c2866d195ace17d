// SPDX-License-Identifier: Apache-2.0
// A view as the part of an address behind "#", and back.

const round = (values) => values.map((v) => Number(v.toFixed(3))).join(',');

/** `state`: what Viewer.state() tells. */
export function toLink(state) {
  const entries = {
    frame: state.frame, camera: round([...state.camera, ...state.target]),
    layers: Object.entries(state.layers).map(([id, l]) => `${id}:${l.shown ? '' : '-'}${l.opacity}`).join(','),
    methods: state.methods.join(','), colour: state.colour, range: state.range,
    part: state.selected ?? undefined, others: state.others === 'shown' ? undefined : state.others,
    hidden: state.hidden.length ? state.hidden.join(',') : undefined,
    cut: state.cut.kind === 'none' ? undefined : `${state.cut.kind},${round([state.cut.offset])},${state.cut.flipped ? 1 : 0}`
      + (state.cut.kind === 'view' ? `,${round(state.cut.normal)}` : ''),
  };
  return Object.entries(entries).filter(([, v]) => v !== undefined && v !== '')
    .map(([k, v]) => `${k}=${encodeURIComponent(v).replace(/%2C/g, ',').replace(/%3A/g, ':')}`).join('&');
}

/** The entries of a link that make sense; everything else is left out, whatever somebody typed. */
export function fromLink(hash) {
  const entries = new Map(hash.replace(/^#/, '').split('&').map((entry) => {
    const [key, ...value] = entry.split('=');
    try { return [key, decodeURIComponent(value.join('='))]; } catch { return [key, '']; }
  }));
  const numbers = (key, count) => {
    const values = (entries.get(key) ?? '').split(',').map(Number);
    return entries.get(key) && values.length >= count && values.every(Number.isFinite) ? values : null;
  };
  const link = {};
  const frame = numbers('frame', 1), camera = numbers('camera', 6), range = numbers('range', 1);
  if (frame) link.frame = Math.max(0, Math.round(frame[0]));
  if (camera) Object.assign(link, { camera: camera.slice(0, 3), target: camera.slice(3, 6) });
  if (range && range[0] > 0) [link.range] = range;
  if (entries.get('layers')) {
    link.layers = {};
    for (const entry of entries.get('layers').split(',')) {
      const [id, text = ''] = entry.split(':');
      const opacity = Number(text.replace('-', ''));
      if (opacity > 0 && opacity <= 1) link.layers[id] = { shown: !text.startsWith('-'), opacity };
    }
  }
  const methods = numbers('methods', 1);
  if (methods) link.methods = methods.slice(0, 2);
  for (const key of ['colour', 'part', 'others']) if (entries.get(key)) link[key] = entries.get(key);
  if (entries.get('hidden')) link.hidden = entries.get('hidden').split(',');
  const cut = (entries.get('cut') ?? '').split(',');
  if (cut.length >= 2 && Number.isFinite(Number(cut[1]))) {
    link.cut = { kind: cut[0], offset: Number(cut[1]), flipped: cut[2] === '1' };
    const normal = cut.slice(3, 6).map(Number);
    if (normal.length === 3 && Math.hypot(...normal) > 0.5) link.cut.normal = normal;
  }
  return link;
}
