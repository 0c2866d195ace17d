// SPDX-License-Identifier: Apache-2.0
// The panel at the side (on phones: at the bottom): layers, colour, section, parts, measures.
import { button, element, labelled, select } from './dom.js';
import { fields } from './fields.js';
import { layers } from './layers.js';
import { cutKinds } from './viewer.js';

const cubicCentimetres = (v) => (v * 1e6).toLocaleString('en', { maximumFractionDigits: v < 1e-4 ? 1 : 0 });
/** "1,234 cm³ (-3.1 %)" of a volume now and at rest. */
function volumeText([now, rest]) {
  const percent = (100 * (now / rest - 1)).toFixed(1);
  return `${cubicCentimetres(now)} cm³ (${percent > 0 ? '+' : ''}${percent} %)`;
}

function section(title, ...children) {
  return element('section', {}, element('h2', {}, title), ...children);
}

function layersSection(viewer) {
  const { hasFlesh } = viewer.recording;
  const rows = layers.filter(({ id }) => hasFlesh || id === 'skin').map(({ id, label }) => {
    const box = element('input', { type: 'checkbox', id: `layer-${id}`, onchange: () => viewer.setLayer(id, { shown: box.checked }) });
    const opacity = element('input', { type: 'range', min: 0.05, max: 1, step: 0.05, 'aria-label': `Opacity of ${label.toLowerCase()}`,
      oninput: () => viewer.setLayer(id, { opacity: Number(opacity.value), shown: true }) });
    const swatch = element('span', { class: 'swatch', style: `background:${layers.find((l) => l.id === id).colour}` });
    const row = element('div', { class: 'layer' }, box, swatch, element('label', { for: box.id }, label), opacity);
    const show = () => {
      box.checked = viewer.layers[id].shown;
      opacity.value = viewer.layers[id].opacity;
    };
    for (const event of ['layers', 'parts', 'ready']) viewer.addEventListener(event, show);
    show();
    return row;
  });
  const volumes = element('p', { class: 'quiet', id: 'volumes' });
  viewer.addEventListener('rendered', () => {
    if (viewer.playing || viewer.frame === volumes.frame) return;
    volumes.frame = viewer.frame;
    const names = hasFlesh ? { skin: 'Body', fat: 'Fat layer', muscle_wrap: 'Muscle layer' } : { skin: 'Body' };
    volumes.replaceChildren(...Object.entries(names).map(([id, name]) =>
      element('span', { 'data-volume': viewer.volumeOf(id)[0] * 1e6 }, `${name} ${volumeText(viewer.volumeOf(id))}`)));
  });
  return section('Layers', ...rows, volumes);
}

function methodsSection(viewer) {
  const names = viewer.recording.head.methods;
  if (names.length < 2) return null;
  const options = Object.fromEntries(names.map((name, m) => [m, name]));
  const first = select('Method', options, (m) => viewer.setMethods(Number(m), viewer.methods[1]));
  const second = select('Method beside it', { none: 'none', ...options }, (m) => viewer.setMethods(viewer.methods[0], Number(m)));
  const show = () => {
    first.value = viewer.methods[0];
    second.value = viewer.methods[1] ?? 'none';
  };
  viewer.addEventListener('methods', show);
  show();
  return section('Methods', element('div', { class: 'pair' }, ...labelled('Show', first), ...labelled('beside', second)));
}

function colourSection(viewer) {
  const several = viewer.recording.head.methods.length > 1, { hasFlesh } = viewer.recording;
  const isKnown = (id) => (id === 'distance' ? several : hasFlesh || id === 'tissue');
  const options = Object.fromEntries(Object.entries(fields).filter(([id]) => isKnown(id))
    .map(([id, field]) => [id, id === 'distance' ? `${field.label} ${viewer.recording.head.methods[0]}` : field.label]));
  const chosen = select('Colour by', options, (colour) => viewer.setColour(colour));
  const range = element('input', { type: 'number', min: 0.1, step: 'any', 'aria-label': 'Value in full colour',
    onchange: () => { if (Number(range.value) > 0) viewer.setColour(viewer.colour, Number(range.value)); } });
  const unit = element('span');
  const about = element('p', { class: 'quiet' });
  const more = element('div', {}, element('div', { class: 'pair' }, ...labelled('Full colour at', range), unit), about);
  const show = () => {
    const field = viewer.field;
    chosen.value = viewer.colour;
    more.hidden = !field;
    if (!field) return;
    range.value = field.shownHigh;
    unit.textContent = field.unit;
    about.textContent = `${field.about}.`;
  };
  viewer.addEventListener('colour', show);
  show();
  return section('Colour', element('div', { class: 'pair' }, ...labelled('By', chosen)), more);
}

function cutSection(viewer) {
  const kind = select('Section', cutKinds, (value) => viewer.setCut({ kind: value, normal: undefined }));
  const offset = element('input', { type: 'range', min: -1.2, max: 1.2, step: 0.005, 'aria-label': 'Place of the section, metres from the pelvis',
    oninput: () => viewer.setCut({ offset: Number(offset.value) }) });
  const flip = button('Other side', 'Show the other side of the section', () => viewer.setCut({ flipped: !viewer.cut.flipped }));
  const place = element('output');
  const more = element('div', { class: 'pair' }, offset, place, flip);
  const show = () => {
    kind.value = viewer.cut.kind;
    more.hidden = viewer.cut.kind === 'none';
    offset.value = viewer.cut.offset;
    place.textContent = `${(100 * viewer.cut.offset).toFixed(1)} cm`;
  };
  viewer.addEventListener('cut', show);
  show();
  return section('Section', element('div', { class: 'pair' }, ...labelled('Plane', kind)), more);
}

const fmaText = (part) => (part.fma ? `FMA ${part.fma}` : 'no FMA id');

function partsSection(viewer) {
  const search = element('input', { type: 'search', placeholder: 'Name or FMA id', 'aria-label': 'Search bones and muscles by name or FMA id', id: 'search', autocomplete: 'off' });
  const list = element('ul', { class: 'parts', role: 'listbox', 'aria-label': 'Bones and muscles', tabindex: 0, id: 'parts' });
  const found = element('p', { class: 'quiet', role: 'status' });
  const info = element('div', { class: 'info', 'aria-live': 'polite', id: 'info' });
  const actions = element('div', { class: 'actions' },
    button('Isolate', 'Show this part alone', () => viewer.setOthers(viewer.others === 'hidden' ? 'shown' : 'hidden'), { id: 'isolate' }),
    button('Ghost rest', 'Ghost everything else', () => viewer.setOthers(viewer.others === 'ghost' ? 'shown' : 'ghost'), { id: 'ghost' }),
    button('Hide', 'Hide this part', () => viewer.hideSelected(), { id: 'hide' }),
    button('Show all', 'Show all parts', () => viewer.showAllParts(), { id: 'show-all' }));
  const fill = () => {
    const words = search.value.toLowerCase().replace(/\bfma\s*:?\s*/, '').split(/[\s_]+/).filter(Boolean);
    const matches = viewer.parts.filter((part) => words.every((word) => part.name.toLowerCase().includes(word) || String(part.fma) === word));
    list.replaceChildren(...matches.map((part) => {
      const chosen = viewer.selectedPart === part;
      return element('li', { role: 'option', 'aria-selected': String(chosen), 'data-part': part.name,
        onclick: () => viewer.select(part.layer, part.index) },
      element('span', { class: `dot ${part.layer}` }), part.name.replaceAll('_', ' '), part.fma ? element('small', {}, ` ${part.fma}`) : null);
    }));
    found.textContent = `${matches.length} of ${viewer.parts.length} parts`;
    list.querySelector('[aria-selected=true]')?.scrollIntoView({ block: 'nearest' });
    return matches;
  };
  search.addEventListener('input', fill);
  search.addEventListener('keydown', (event) => {
    if (event.key === 'ArrowDown') list.focus();
    if (event.key === 'Enter') {
      const [part] = fill();
      if (part) viewer.select(part.layer, part.index);
    }
  });
  list.addEventListener('keydown', (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const names = [...list.children].map((item) => item.dataset.part);
    const at = names.indexOf(viewer.selectedPart?.name);
    const part = viewer.partOf(names[Math.max(0, Math.min(names.length - 1, at + step))]);
    if (part) viewer.select(part.layer, part.index);
  });
  const showVolume = () => {
    const part = viewer.selectedPart;
    const line = info.querySelector('.volume');
    if (!part || !line || viewer.playing || !viewer.anatomy[part.layer]) return;
    line.textContent = viewer.methods.map((m, slot) => `${viewer.methods.length > 1 ? `${viewer.recording.head.methods[m]} ` : ''}${volumeText(viewer.volumeOf('part', slot))}`).join(', ');
  };
  const show = () => {
    const part = viewer.selectedPart;
    info.replaceChildren(...(part ? [element('strong', {}, part.name.replaceAll('_', ' ')),
      element('span', {}, `${part.layer === 'bones' ? 'bone' : 'muscle'}, ${part.side}, ${fmaText(part)}`), element('span', { class: 'volume' })] : ['Click a bone or muscle, or search it.']));
    for (const id of ['isolate', 'ghost', 'hide']) actions.querySelector(`#${id}`).disabled = !part;
    actions.querySelector('#isolate').setAttribute('aria-pressed', viewer.others === 'hidden');
    actions.querySelector('#ghost').setAttribute('aria-pressed', viewer.others === 'ghost');
    fill();
  };
  viewer.addEventListener('parts', show);
  viewer.addEventListener('rendered', showVolume);
  show();
  return section('Bones and muscles', search, info, actions, list, found);
}

function measureSection(viewer, tools) {
  const toggle = button('Measure', 'Measure between two points: click them', () => tools.setMeasuring(!tools.measuring), { id: 'measure' });
  const result = element('output', { id: 'distance' });
  const clear = button('Clear', 'Remove the measured points', () => { viewer.marks = []; viewer.changed('marks'); });
  const show = () => {
    toggle.setAttribute('aria-pressed', !!tools.measuring);
    clear.hidden = viewer.marks.length === 0;
    result.textContent = viewer.marks.length === 2
      ? viewer.methods.map((m, slot) => `${viewer.methods.length > 1 ? `${viewer.recording.head.methods[m]} ` : ''}${(1000 * viewer.distance(slot)).toFixed(1)} mm`).join(', ')
      : tools.measuring ? `click ${viewer.marks.length === 1 ? 'the second point' : 'two points'}` : '';
  };
  viewer.addEventListener('marks', show);
  viewer.addEventListener('rendered', show);
  tools.onchange = show;
  show();
  return section('Distance', element('div', { class: 'pair' }, toggle, clear), result);
}

function viewSection(viewer, tools) {
  const sides = { front: 'Front', back: 'Back', left: 'Left', right: 'Right', above: 'Above' };
  return section('View',
    element('div', { class: 'actions' }, ...Object.entries(sides).map(([side, text]) => button(text, `Look from: ${text.toLowerCase()}`, () => viewer.lookFrom(side)))),
    element('div', { class: 'actions' }, button('Save PNG', 'Save the picture as PNG', () => tools.savePng(), { id: 'png' }),
      button('Copy link', 'Copy a link to this view', () => tools.copyLink(), { id: 'link' }),
      button('Keys', 'Show the keys', () => tools.showKeys())));
}

export function makePanel(viewer, tools) {
  const { head } = viewer.recording;
  return element('aside', { id: 'panel', 'aria-label': 'Controls' },
    methodsSection(viewer), layersSection(viewer), cutSection(viewer), colourSection(viewer),
    head.bones.length + head.muscles.length > 0 ? partsSection(viewer) : null, measureSection(viewer, tools), viewSection(viewer, tools),
    element('details', {}, element('summary', {}, 'Licences'), element('pre', {}, head.credits || 'no third-party data'),
      element('p', { class: 'quiet' }, 'Viewer: Apache-2.0. three.js: MIT, its licence stands in this file.')));
}
