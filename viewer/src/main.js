// SPDX-License-Identifier: Apache-2.0
// A page: NdgViewer.open(head), then add(block) for each block as the browser reads it, then end().
import { decode } from './blocks.js';
import { button, element } from './dom.js';
import { layers } from './layers.js';
import { fromLink, toLink } from './link.js';
import { makePanel } from './panel.js';
import style from './style.css';
import { Viewer } from './viewer.js';

const keys = [['Space', 'play and pause'], ['← →', 'one frame, with shift ten'], ['Home End', 'first and last frame'],
  ['1 to 6', 'layers from outside in'], ['[ ]', 'turn'], ['+ -', 'nearer and farther'], ['C', 'next section plane'], ['/', 'search'],
  ['I G H A', 'isolate, ghost the rest, hide, show all'], ['M', 'measure'], ['Esc', 'select nothing'], ['?', 'this list']];

let viewer = null, queue = Promise.resolve(), linkTimer = null;
const problems = [];

function timeline() {
  const { head } = viewer.recording;
  const play = button('▶', 'Play', () => viewer.play(), { id: 'play' });
  const scrubber = element('input', { type: 'range', id: 'scrubber', min: 0, max: head.num_frames - 1, step: 1, value: 0, 'aria-label': 'Frame',
    oninput: () => {
      const frame = Number(scrubber.value);  // pausing shows the frame that is
      viewer.play(false);
      viewer.setFrame(frame);
    } });
  const loaded = element('div', { id: 'loaded' });
  const time = element('output', { id: 'time', for: 'scrubber' });
  const step = (by) => () => { viewer.play(false); viewer.setFrame(viewer.frame + by); };
  const show = () => {
    play.textContent = viewer.playing ? '❚❚' : '▶';
    play.setAttribute('aria-label', viewer.playing ? 'Pause' : 'Play');
    scrubber.value = viewer.frame;
    scrubber.setAttribute('aria-valuetext', `frame ${viewer.frame + 1} of ${head.num_frames}`);
    time.textContent = `${viewer.frame + 1} / ${head.num_frames}   ${(viewer.frame / head.frame_rate).toFixed(2)} s`;
    loaded.style.width = `${(100 * viewer.numLoaded) / head.num_frames}%`;
  };
  for (const event of ['frame', 'play', 'loaded']) viewer.addEventListener(event, show);
  const speed = element('select', { 'aria-label': 'Speed', onchange: () => { viewer.speed = Number(speed.value); viewer.clock = null; } },
    ...[0.25, 0.5, 1, 2].map((s) => element('option', { value: s, selected: s === 1 }, `${s}×`)));
  show();
  return element('footer', { id: 'timeline', 'aria-label': 'Time' }, play, button('‹', 'One frame back', step(-1), { id: 'back' }),
    button('›', 'One frame on', step(1), { id: 'on' }), element('div', { id: 'track' }, loaded, scrubber), time, speed);
}

/** Names of the methods over their pictures. */
function captions(view) {
  const own = [0, 1].map(() => element('div', { class: 'caption' }));
  const place = () => {
    const { boxes } = viewer;
    own.forEach((caption, slot) => {
      const box = boxes[slot];
      caption.hidden = !box;
      if (!box) return;
      caption.textContent = viewer.recording.head.methods[viewer.methods[slot]];
      Object.assign(caption.style, { left: `${box.x + box.width / 2}px`, top: `${viewer.height - box.y - box.height + 36}px` });
    });
  };
  viewer.addEventListener('rendered', place);
  view.append(...own);
}

function colourBar(view) {
  const strip = element('div', { class: 'strip' }), low = element('span'), name = element('strong'), high = element('span');
  const bar = element('div', { id: 'bar', role: 'img' }, name, strip, element('div', { class: 'ends' }, low, high));
  const show = () => {
    const field = viewer.field;
    bar.hidden = !field;
    if (!field) return;
    name.textContent = viewer.colour === 'distance' ? `${field.label} ${viewer.recording.head.methods[0]}` : field.label;
    strip.style.background = `linear-gradient(to right, ${field.colours.join(',')})`;
    low.textContent = `${field.shownLow} ${field.unit}`;
    high.textContent = `${field.low < 0 ? '+' : ''}${field.shownHigh} ${field.unit}`;
    bar.setAttribute('aria-label', `${name.textContent} from ${low.textContent} to ${high.textContent}`);
  };
  viewer.addEventListener('colour', show);
  show();
  view.append(bar);
}

/** Measured points and the line between them, over the picture. */
function marks(view) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('class', 'marks');
  svg.setAttribute('aria-hidden', 'true');
  const draw = (tag, attributes) => {
    const shape = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [name, value] of Object.entries(attributes)) shape.setAttribute(name, value);
    svg.append(shape);
  };
  viewer.addEventListener('rendered', () => {
    svg.replaceChildren();
    if (viewer.marks.length === 0) return;
    viewer.methods.forEach((_, slot) => {
      const at = viewer.markPoints(slot).map((point) => viewer.project(point, slot));
      if (at.length === 2) draw('line', { x1: at[0][0], y1: at[0][1], x2: at[1][0], y2: at[1][1] });
      for (const [x, y] of at) draw('circle', { cx: x, cy: y, r: 4 });
    });
  });
  view.append(svg);
}

function makeTools(view) {
  const help = element('dialog', { id: 'keys', 'aria-label': 'Keys' }, element('dl', {}, ...keys.flatMap(([key, what]) => [element('dt', {}, key), element('dd', {}, what)])),
    button('Close', 'Close', () => help.close()));
  const notice = element('div', { id: 'notice', role: 'status' });
  view.append(help, notice);
  const tools = {
    measuring: false,
    setMeasuring(on) {
      tools.measuring = on;
      view.classList.toggle('measuring', on);
      tools.onchange?.();
    },
    say(text) {
      notice.textContent = text;
      clearTimeout(tools.timer);
      tools.timer = setTimeout(() => { notice.textContent = ''; }, 2500);
    },
    async savePng() {
      const url = URL.createObjectURL(await viewer.png());
      element('a', { href: url, download: `${document.title.replace(/\W+/g, '-')}-${viewer.frame + 1}.png` }).click();
      setTimeout(() => URL.revokeObjectURL(url), 10000);
    },
    link: () => `${location.href.split('#')[0]}#${toLink(viewer.state())}`,
    async copyLink() {
      writeLink();
      try {
        await navigator.clipboard.writeText(tools.link());
        tools.say('Link copied');
      } catch {
        tools.say('The link stands in the address bar');  // pages in frames and from files may not use the clipboard
      }
    },
    showKeys: () => help.showModal(),
  };
  return tools;
}

function writeLink() {
  // Some frames have no address of their own.
  try { history.replaceState(null, '', `#${toLink(viewer.state())}`); } catch { /* then there is no link to write */ }
}

/** Name under the pointer; a click selects, or marks a point when measuring. */
function pointer(view, canvas, tools) {
  const tip = element('div', { id: 'tip', role: 'tooltip', hidden: true });
  view.append(tip);
  let down = null, last = 0;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const nameOf = (found) => (found.part === null ? layers.find((l) => l.id === found.id).label
    : viewer.recording.head[found.id][found.part].name.replaceAll('_', ' '));
  canvas.addEventListener('pointerdown', (event) => { down = place(event); tip.hidden = true; });
  canvas.addEventListener('pointermove', (event) => {
    if (event.buttons || viewer.playing || event.pointerType === 'touch' || event.timeStamp - last < 70) return;
    last = event.timeStamp;
    const [x, y] = place(event), found = viewer.pickAt(x, y);
    tip.hidden = !found;
    if (!found) return;
    tip.textContent = nameOf(found);
    Object.assign(tip.style, { left: `${Math.min(x + 14, viewer.width - 160)}px`, top: `${y + 14}px` });
  });
  canvas.addEventListener('pointerleave', () => { tip.hidden = true; });
  canvas.addEventListener('pointerup', (event) => {
    const [x, y] = place(event);
    if (!down || Math.hypot(x - down[0], y - down[1]) > 5) return;
    down = null;
    const found = viewer.pickAt(x, y);
    if (tools.measuring) {
      if (found) viewer.mark(found);
    } else if (!found || found.part === null) viewer.select(null);
    else viewer.select(found.id, found.part);
  });
}

function keyboard(tools) {
  const kinds = ['none', 'side', 'height', 'depth', 'view'];
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const typing = event.target.closest?.('input:not([type=range]):not([type=checkbox]), select, dialog');
    if (event.key === 'Escape' && !event.target.closest?.('dialog')) {
      if (tools.measuring) tools.setMeasuring(false);
      else viewer.select(null);
      event.target.blur?.();
    }
    if (typing) return;
    const onControl = event.target.closest?.('button, summary, input');
    const steps = event.shiftKey ? 10 : 1;
    const actions = {
      ArrowLeft: () => { viewer.play(false); viewer.setFrame(viewer.frame - steps); },
      ArrowRight: () => { viewer.play(false); viewer.setFrame(viewer.frame + steps); },
      Home: () => viewer.setFrame(0), End: () => viewer.setFrame(viewer.numFrames - 1),
      '[': () => viewer.turn(Math.PI / 12), ']': () => viewer.turn(-Math.PI / 12), '+': () => viewer.zoom(0.9), '-': () => viewer.zoom(1 / 0.9),
      c: () => viewer.setCut({ kind: kinds[(kinds.indexOf(viewer.cut.kind) + 1) % kinds.length], normal: undefined }),
      '/': () => document.getElementById('search')?.focus(), '?': () => tools.showKeys(), m: () => tools.setMeasuring(!tools.measuring),
      i: () => viewer.setOthers('hidden'), g: () => viewer.setOthers('ghost'), h: () => viewer.hideSelected(), a: () => viewer.showAllParts(),
    };
    layers.forEach(({ id }, k) => { actions[k + 1] = () => viewer.setLayer(id, { shown: !viewer.layers[id].shown }); });
    if (!onControl) actions[' '] = () => viewer.play();
    const isSlider = event.target.matches?.('input[type=range]') && /^(Arrow|Home|End)/.test(event.key);
    const action = isSlider ? null : actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}

function fail(text) {
  problems.push(text);
  document.body.append(element('p', { id: 'problem', role: 'alert' }, text));
}

export function open(head) {
  document.head.append(element('style', {}, style));
  const canvas = element('canvas', { id: 'picture', tabindex: 0, role: 'img', 'aria-label': `${head.title}: a body in motion. Drag to turn, wheel or pinch to zoom.` });
  const view = element('main', { id: 'view' }, canvas);
  try {
    viewer = new Viewer(head, canvas);
  } catch (error) {
    fail(`This browser shows no 3D pictures (WebGL 2): ${error.message}`);
    return;
  }
  const tools = makeTools(view);
  const panel = makePanel(viewer, tools);
  const menu = button('☰', 'Show or hide the controls', () => {
    const closed = document.body.classList.toggle('closed');
    menu.setAttribute('aria-expanded', String(!closed));
  }, { id: 'menu', 'aria-expanded': 'true', 'aria-controls': 'panel' });
  const small = matchMedia('(max-width: 700px)');
  if (small.matches || (window !== window.top && innerWidth < 900)) menu.click();
  view.append(element('h1', {}, head.title), menu);
  captions(view);
  colourBar(view);
  marks(view);
  pointer(view, canvas, tools);
  keyboard(tools);
  document.body.append(view, panel, timeline());
  new ResizeObserver(() => viewer.resize(view.clientWidth, view.clientHeight, devicePixelRatio)).observe(view);
  viewer.resize(view.clientWidth, view.clientHeight, devicePixelRatio);
  let written = location.hash;
  viewer.addEventListener('ready', () => {
    viewer.restore(head.opening ?? {});
    viewer.restore(fromLink(location.hash));
  });
  addEventListener('hashchange', () => { if (location.hash !== written) viewer.restore(fromLink(location.hash)); });
  viewer.addEventListener('rendered', () => {
    clearTimeout(linkTimer);
    linkTimer = setTimeout(() => { if (!viewer.playing && viewer.isComplete) { writeLink(); written = location.hash; } }, 400);
  });
  const loop = (now) => {
    viewer.tick(now);
    requestAnimationFrame(loop);
  };
  requestAnimationFrame(loop);
}

export function add(block) {
  if (!viewer) return;
  queue = queue.then(async () => {
    viewer.add(block, await decode(block));
    block.data = null;
    // Between blocks the browser may draw.
    await new Promise((resolve) => { setTimeout(resolve); });
  }).catch((error) => fail(`The page is damaged (${block.name}): ${error.message}`));
}

export function end() {
  queue.then(() => {
    if (!viewer) return;
    viewer.times.complete = performance.now() - viewer.times.opened;
    if (!viewer.isComplete) fail(`The page is damaged: ${viewer.numLoaded} of ${viewer.numFrames} frames are there`);
    for (const script of document.querySelectorAll('body > script')) script.remove();  // their text is decoded
  });
}

/** For tests and for pages around this one. */
export const state = () => ({ ...viewer?.state(), problems });
export const get = () => viewer;
