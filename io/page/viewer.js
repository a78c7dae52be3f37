// The page: settings, the grid of tiles, the large view, tables. What is shown is in the fragment of the
// address, so that a link shows a view: #model=ID&points=N&color=density|rank|normal|label|...&style=dots&size=S&up=z&detail=view
// &yaw=&pitch=&zoom=&x=&y=&text=&label=&sort=&theme=dark.

const byId = (id) => document.getElementById(id);
const FIRST_VIEW = {yaw: -0.6, pitch: 0.35, zoom: 1, x: 0, y: 0};
// The colors of the models, where the store has them.
const FIRST_COLOR = facts.colorings.some((coloring) => coloring.word === 'rgb') ? 'rgb' : 'plain';
const FIRST_SETTINGS = {
  model: '', points: facts.points, color: FIRST_COLOR, style: 'discs', size: 1, up: 'y', detail: 'all', text: '', label: '', sort: 'id', theme: '',
};
const settings = {...FIRST_SETTINGS};
const view = {...FIRST_VIEW};
const MOST_KEYS = 12;  // of classes in a legend
const positionOf = new Map(facts.models.map((model, position) => [model.id, position]));

let renderer = null;
let shown = [];          // positions in the grid, filtered and sorted
let opened = -1;         // position in the large view
let drawnOnce = false;

// ---- settings and the address -------------------------------------------------------------------------------

function clamp(value, low, high) {
  return Math.min(high, Math.max(low, value));
}

function readFragment() {
  const given = new URLSearchParams(location.hash.slice(1));
  Object.assign(settings, FIRST_SETTINGS);
  Object.assign(view, FIRST_VIEW);
  if (given.has('colour')) settings.color = given.get('colour');  // as links of older pages have it
  for (const name of Object.keys(settings)) if (given.has(name)) settings[name] = given.get(name);
  for (const name of Object.keys(view)) {
    const number = parseFloat(given.get(name));
    if (Number.isFinite(number)) view[name] = number;
  }
  const choices = {color: [...byId('color').options].map((option) => option.value), style: ['discs', 'surface', 'dots'], up: ['y', 'z'], detail: ['all', 'view'], theme: ['', 'light', 'dark'],
                   sort: [...byId('sort').options].map((option) => option.value)};
  for (const [name, words] of Object.entries(choices))
    if (!words.includes(settings[name])) settings[name] = FIRST_SETTINGS[name];
  settings.points = clamp(Math.round(Number(settings.points)) || facts.points, 1, Math.max(1, facts.points));
  settings.size = clamp(Number(settings.size) || 1, 0.2, 3);
  view.zoom = clamp(view.zoom, 0.2, 60);
}

function writeFragment() {
  const kept = new URLSearchParams();
  for (const [name, value] of Object.entries(settings))
    if (String(value) !== String(FIRST_SETTINGS[name])) kept.set(name, value);
  for (const [name, value] of Object.entries(view))
    if (value !== FIRST_VIEW[name]) kept.set(name, Number(value.toFixed(3)));
  const text = kept.toString();
  try {
    history.replaceState(null, '', text ? '#' + text : location.pathname + location.search);
  } catch {
    // A browser that forbids it for files from disk: the page works without.
  }
}
let fragmentTimer = 0;
function writeFragmentSoon() {
  clearTimeout(fragmentTimer);
  fragmentTimer = setTimeout(writeFragment, 200);
}

// The slider runs over the logarithm: 1 to all points.
const sliderOf = (points) => facts.points <= 1 ? 1000 : Math.round((1000 * Math.log(points)) / Math.log(facts.points));
const pointsOfSlider = (place) => Math.round(Math.exp((place / 1000) * Math.log(Math.max(1, facts.points))));

function showSettings() {
  byId('points').value = sliderOf(settings.points);
  byId('points-text').value = `${formatted(settings.points)} of ${formatted(facts.points)}`;
  for (const name of ['color', 'style', 'size', 'up', 'detail', 'text', 'label', 'sort', 'theme']) byId(name).value = settings[name];
  if (settings.theme) document.documentElement.dataset.theme = settings.theme;
  else document.documentElement.dataset.theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  showLegend();
}

// A bar of the color map between its ends.
function rampBetween(low, high) {
  const ramp = document.createElement('canvas');
  [ramp.width, ramp.height] = [256, 1];
  const pixels = ramp.getContext('2d');
  for (let i = 0; i < 256; ++i) {
    pixels.fillStyle = `rgb(${lagoonColor(i / 255).join(' ')})`;
    pixels.fillRect(i, 0, 1, 1);
  }
  return [low, ramp, high];
}

// The end of a range of numbers, or of the model that is shown.
function rangeLegend(title, range) {
  if (!range) return rampBetween(title + ': lowest', 'highest of each model');
  if (range.length === 0) return [title + ': no value'];
  if (range[0] === range[1]) return [`${title} ${brief(range[0])} everywhere`];
  return rampBetween(`${title} ${brief(range[0])}`, brief(range[1]));
}

function classKey(number, name) {
  const key = element('span', undefined, 'key');
  const swatch = document.createElement('i');
  swatch.style.background = `rgb(${classColor(number).join(' ')})`;
  key.append(swatch, isolated(shortened(name, 24)));
  return key;
}

function legendParts() {
  const model = facts.models[opened];
  const c = facts.colorings.findIndex((coloring) => coloring.word === settings.color);
  const {title, kind} = facts.colorings[c] ?? {};
  if (kind === 'number') return rangeLegend(title, model?.paint[c]);
  if (kind === 'colors') return [title + (settings.color === 'texcoord' ? ': red u, green v, from 0 to 1 and again' : '')];
  if (kind === 'classes') {
    const keys = model?.paint[c] ?? [];
    return keys.length > 0 ? keys.map(([number, name]) => classKey(number, name)) : [title + ': a color for each'];
  }
  switch (settings.color) {
    case 'normal': return ['red, green, blue: x, y, z'];
    case 'rank': return rampBetween('curve: first', 'last');
    case 'density': return rangeLegend('density', model?.density);
    case 'label': {
      const used = [...new Set((model ? [model] : facts.models).map((one) => one.label))].sort((a, b) => a - b);
      return used.length > MOST_KEYS ? ['a color for each class']
                                     : used.map((label) => classKey(label, label < 0 ? 'none' : facts.labels[label]));
    }
  }
  return [];
}

function showLegend() {
  byId('legend').replaceChildren(...legendParts());
}

function themeColors() {
  const dark = document.documentElement.dataset.theme === 'dark';
  return dark ? {stage: [0.125, 0.137, 0.153], plain: [0.52, 0.55, 0.59], sample: [0.95, 0.60, 0.42]} : {stage: [0.945, 0.953, 0.961], plain: [0.76, 0.79, 0.83], sample: [0.77, 0.24, 0.11]};
}

// ---- drawing ------------------------------------------------------------------------------------------------

const visibleTiles = new Set();
const waiting = new Set();  // canvases to be drawn in the next frames
let frameAsked = false;
const FRAME_MILLISECONDS = 24;
// More points are drawn with hard rims; the large view gets smooth ones as soon as it rests.
const QUICK_POINTS = 20000;
const REST_MILLISECONDS = 300;
let restTimer = 0;

function askFrame() {
  if (frameAsked) return;
  frameAsked = true;
  requestAnimationFrame(() => drawFrame(FRAME_MILLISECONDS));
}

// The large view, then tiles for as long as a frame should take; the rest in the next one.
function drawFrame(most) {
  frameAsked = false;
  if (renderer && !renderer.gl.isContextLost()) {
    const begin = performance.now();
    if (opened >= 0 && waiting.delete(byId('large'))) drawLarge();
    for (const canvas of waiting) {
      waiting.delete(canvas);
      if (visibleTiles.has(canvas)) drawTile(canvas);
      if (performance.now() - begin > most) break;
    }
    if (waiting.size > 0) askFrame();
  }
  const nothingToDraw = !renderer || (opened < 0 && shown.length === 0);
  if (waiting.size === 0 && (drawnOnce || nothingToDraw)) setTitle();
}

function pixelsOf(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  return [Math.max(1, Math.round(canvas.clientWidth * ratio)), Math.max(1, Math.round(canvas.clientHeight * ratio))];
}

function drawTile(canvas) {
  const [width, height] = pixelsOf(canvas);
  renderer.paint(canvas, canvas.position, width, height, settings, FIRST_VIEW, themeColors(), settings.points > QUICK_POINTS);
  drawnOnce = true;
}

function drawLarge(atRest = false) {
  const canvas = byId('large');
  const [width, height] = pixelsOf(canvas);
  const quick = !atRest && settings.points > QUICK_POINTS;
  renderer.paint(canvas, opened, width, height, settings, view, themeColors(), quick);
  if (settings.detail === 'view') byId('points-text').value = `${formatted(renderer.kept)} of ${formatted(settings.points)} for this view`;
  drawnOnce = true;
  clearTimeout(restTimer);
  if (quick) restTimer = setTimeout(drawAtRest, REST_MILLISECONDS);
}

function drawAtRest() {
  if (opened >= 0 && renderer && !renderer.gl.isContextLost()) drawLarge(true);
}

// What is in the window is drawn before the page is first shown, without waiting for frames.
function drawAtOnce() {
  for (const canvas of document.querySelectorAll('.tile canvas')) {
    const place = canvas.getBoundingClientRect();
    if (place.top > window.innerHeight) break;
    if (place.width === 0) continue;
    visibleTiles.add(canvas);
    waiting.add(canvas);
  }
  drawFrame(Infinity);
}

// Everything visible again.
function redraw() {
  for (const canvas of visibleTiles) waiting.add(canvas);
  if (opened >= 0) waiting.add(byId('large'));
  askFrame();
}
function redrawLarge() {
  waiting.add(byId('large'));
  askFrame();
}

// The title of the window tells that what is visible is drawn.
function setTitle() {
  const name = opened >= 0 ? facts.models[opened].id + ' \u2013 ' + facts.store : facts.store;
  const count = facts.models.length;
  document.title = `${name} \u2013 ${formatted(count)} model${count === 1 ? '' : 's'}${renderer ? '' : ' (not drawn)'}`;
}

const tileWatcher = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    const canvas = entry.target;
    if (entry.isIntersecting) {
      visibleTiles.add(canvas);
      waiting.add(canvas);
    } else {
      visibleTiles.delete(canvas);
      waiting.delete(canvas);
      canvas.width = canvas.height = 1;  // its pixels are given back
    }
  }
  askFrame();
}, {rootMargin: '200px 0px'});

function makeTile(position, captionLength, extra) {
  const model = facts.models[position];
  const tile = element('button', undefined, 'tile');
  tile.type = 'button';
  tile.title = model.id;
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 1;
  canvas.position = position;
  const caption = element('span', undefined, 'caption');
  caption.append(isolated(shortened(model.id, captionLength)));
  const second = isolated(extra ?? labelOf(model));
  second.className = 'label';
  if (second.textContent) caption.append(second);
  tile.append(canvas, caption);
  tile.addEventListener('click', () => openModel(position));
  tileWatcher.observe(canvas);
  return tile;
}

function removeTiles(parent) {
  for (const canvas of parent.querySelectorAll('canvas')) {
    tileWatcher.unobserve(canvas);
    visibleTiles.delete(canvas);
    waiting.delete(canvas);
  }
  parent.replaceChildren();
}

// ---- the grid -----------------------------------------------------------------------------------------------

// Orders offered: by id, by area, and by every certificate, worst first.
function sortChoices() {
  const choices = [['id', 'id', null], ['area', 'area, largest first', (model) => -model.area]];
  let at = 0;
  for (const schema of facts.values) {
    const place = at;
    at += schema.width;
    if (schema.group === 'certificate')
      choices.push([schema.name, schema.name.replaceAll('_', ' ') + ', largest first', (model) => -(model.values[place] ?? -Infinity)]);
  }
  return choices;
}

function matching() {
  const wanted = settings.text.toLowerCase();
  const key = sortChoices().find(([name]) => name === settings.sort)?.[2];
  const found = [];
  facts.models.forEach((model, position) => {
    if (wanted && !model.id.toLowerCase().includes(wanted)) return;
    if (settings.label !== '' && String(model.label) !== settings.label) return;
    found.push(position);
  });
  if (key) found.sort((a, b) => key(facts.models[a]) - key(facts.models[b]) || a - b);
  return found;
}

function fillGrid() {
  shown = matching();
  removeTiles(byId('grid'));
  byId('grid').append(...shown.map((position) => makeTile(position, 25)));
  byId('matches').value = shown.length === facts.models.length ? '' : `${formatted(shown.length)} of ${formatted(facts.models.length)}`;
  byId('nothing').hidden = shown.length > 0 || facts.models.length === 0;
  askFrame();
}

// ---- the large view -----------------------------------------------------------------------------------------

let gridScroll = 0;

function openModel(position) {
  if (opened < 0) gridScroll = window.scrollY;
  opened = position;
  settings.model = facts.models[position].id;
  byId('collection').hidden = true;
  byId('viewer').hidden = false;
  byId('name').textContent = settings.model;
  byId('large').setAttribute('aria-label', 'Points of ' + settings.model);
  const place = shown.indexOf(position);
  byId('previous').disabled = place <= 0;
  byId('next').disabled = place < 0 || place + 1 >= shown.length;
  fillFacts(position);
  window.scrollTo(0, 0);
  showLegend();
  redraw();
  writeFragmentSoon();
}

function closeModel() {
  opened = -1;
  settings.model = '';
  removeTiles(byId('facts-of-model'));
  byId('viewer').hidden = true;
  byId('collection').hidden = facts.models.length === 0;
  Object.assign(view, FIRST_VIEW);
  window.scrollTo(0, gridScroll);
  showLegend();
  redraw();
  writeFragmentSoon();
}

function fillFacts(position) {
  const side = byId('facts-of-model');
  removeTiles(side);
  const model = facts.models[position];
  side.append(element('h3', 'Model'), geometryList(model), ...noteParts(model), ...valueLists(model));
  facts.near.forEach((lists, h) => {
    const near = lists[position];
    if (near.length === 0) return;
    side.append(element('h3', 'Nearest by ' + facts.histograms[h].name));
    const tiles = element('div', undefined, 'near');
    for (let i = 0; i < near.length; i += 2) {
      const other = facts.models[near[i]];
      tiles.append(makeTile(near[i], 12, [brief(near[i + 1]), labelOf(other)].filter(Boolean).join(' ')));
    }
    side.append(tiles, element('p', `L1 distances to the models of this page`, 'note'));
  });
  side.append(...histogramCharts(position));
}

function step(by) {
  const place = shown.indexOf(opened) + by;
  if (opened >= 0 && place >= 0 && place < shown.length) openModel(shown[place]);
}

function turnBy(x, y) {
  view.yaw += x;
  view.pitch = clamp(view.pitch + y, -Math.PI / 2, Math.PI / 2);
}

function zoomBy(factor) {
  const zoom = clamp(view.zoom * factor, 0.2, 60);
  view.x *= zoom / view.zoom;
  view.y *= zoom / view.zoom;
  view.zoom = zoom;
}

function resetView() {
  Object.assign(view, FIRST_VIEW);
  changedView();
}

function changedView() {
  redrawLarge();
  writeFragmentSoon();
}

// One pointer turns (or moves, with shift or another button), two move and enlarge.
function watchPointers(canvas) {
  const held = new Map();
  const middle = () => [...held.values()].reduce(([x, y], [px, py]) => [x + px / held.size, y + py / held.size], [0, 0]);
  const spread = () => {
    const [a, b] = [...held.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.classList.add('held');
    canvas.focus({preventScroll: true});
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!held.has(event.pointerId)) return;
    const [before, apart] = [middle(), held.size === 2 ? spread() : 0];
    held.set(event.pointerId, [event.clientX, event.clientY]);
    const after = middle();
    const [dx, dy] = [after[0] - before[0], after[1] - before[1]];
    if (held.size === 2 && apart > 0) zoomBy(spread() / apart);
    if (held.size > 1 || event.shiftKey || event.buttons > 1) {
      view.x += (2 * dx) / canvas.clientHeight;
      view.y -= (2 * dy) / canvas.clientHeight;
    } else {
      turnBy(dx * 0.009, dy * 0.009);
    }
    changedView();
  });
  const release = (event) => {
    held.delete(event.pointerId);
    if (held.size === 0) canvas.classList.remove('held');
  };
  canvas.addEventListener('pointerup', release);
  canvas.addEventListener('pointercancel', release);
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 24 : event.deltaMode === 2 ? 400 : 1);
    zoomBy(Math.exp(-clamp(pixels, -400, 400) * 0.0016));
    changedView();
  }, {passive: false});
}

function pressedKey(event) {
  if (opened < 0 || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === 'Escape') return facts.models.length > 1 ? closeModel() : undefined;
  if (event.target.matches('input, select, textarea')) return;
  const actions = {
    PageUp: () => step(-1), PageDown: () => step(1), 0: resetView,
    '+': () => zoomBy(1.15), '=': () => zoomBy(1.15), '-': () => zoomBy(1 / 1.15),
  };
  if (event.target === byId('large'))
    Object.assign(actions, {
      ArrowLeft: () => turnBy(-0.12, 0), ArrowRight: () => turnBy(0.12, 0),
      ArrowUp: () => turnBy(0, -0.12), ArrowDown: () => turnBy(0, 0.12),
    });
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  action();
  changedView();
}

// ---- tables and the beginning ------------------------------------------------------------------------------

function fillHead() {
  byId('store').textContent = facts.store;
  const parts = [`${formatted(facts.rows)} row${facts.rows === 1 ? '' : 's'}`, `${formatted(facts.ok)} with points`];
  if (facts.failed > 0) parts.push(`${formatted(facts.failed)} failed`);
  parts.push(`${formatted(facts.samples)} points each`);
  byId('summary').textContent = parts.join(', ') + '.';
  const notes = [];
  const count = facts.models.length;
  if (facts.named) notes.push(`This page shows ${formatted(facts.wanted)} models that were named`);
  if (count < facts.wanted) notes.push(`${formatted(count)} of ${formatted(facts.wanted)} models are shown, spread over the ids (--models)`);
  if (facts.points < facts.samples && count > 0)
    notes.push(facts.order === 'progressive' ? `the first ${formatted(facts.points)} points of each model are shown (--points)`
                                             : `${formatted(facts.points)} points of each model are shown, spread along the curve (--points)`);
  if (notes.length > 0) notice(notes.join('; ') + '.');
}

function notice(text) {
  const place = byId('notice');
  place.hidden = false;
  place.append(element('span', (place.textContent ? ' ' : '') + text));
}

function fillFailures() {
  const section = byId('failures');
  section.hidden = facts.failed === 0;
  section.querySelector('h2').textContent = facts.failed === 1 ? 'One model failed' : `${formatted(facts.failed)} models failed`;
  const body = section.querySelector('tbody');
  for (const [id, status, reason] of facts.failures) {
    const row = document.createElement('tr');
    for (const text of [id, status.replaceAll('_', ' '), reason]) {
      const cell = document.createElement('td');
      cell.append(isolated(text));
      row.append(cell);
    }
    body.append(row);
  }
  const missing = facts.failed - facts.failures.length;
  section.querySelector('.more').textContent = missing > 0 ? `and ${formatted(missing)} more, which \`meander info --failed\` lists` : '';
}

function fillRun() {
  const order = facts.order === 'progressive' ? 'progressive: the first points are a set of their own' : 'along the curve';
  fillList(byId('origin'), [
    ['store', facts.store], ['content', facts.content], ['order', order], ['seed', String(facts.seed)],
    ['coordinates', 'points as stored (--normalize), sizes and areas in units of the files'],
    ['made by', `meander ${facts.tool_version}`], ['versions', `format ${facts.format_version}, method ${facts.method_version}`],
  ]);
  try {
    const parameters = JSON.parse(facts.parameters);
    fillList(byId('parameters'), Object.entries(parameters).map(([name, value]) =>
      [name, typeof value === 'string' ? value : JSON.stringify(value)]));
  } catch {
    fillList(byId('parameters'), [['parameters', facts.parameters]]);
  }
}

function fillChoices() {
  const used = [...new Set(facts.models.map((model) => model.label))].filter((label) => label >= 0).sort((a, b) => a - b);
  byId('detail-choice').hidden = !onlyPrefixes;
  byId('label-choice').hidden = used.length === 0;
  const choices = [['', 'all'], ...used.map((label) => [String(label), facts.labels[label]])];
  if (facts.models.some((model) => model.label < 0)) choices.push(['-1', 'none']);
  for (const [value, text] of choices) byId('label').append(new Option(shortened(text, 40), value));
  const colors = [...(used.length > 0 ? [{word: 'label', title: 'class'}] : []), ...facts.colorings];
  byId('color').append(...colors.map(({word, title}) => new Option(shortened(title, 40), word)));
  for (const [value, text] of sortChoices()) byId('sort').append(new Option(text, value));
  const noModels = facts.models.length === 0;
  byId('bar').hidden = byId('collection').hidden = noModels;
  for (const id of ['filters', 'back', 'previous', 'next']) byId(id).hidden = facts.models.length < 2;
}

function applyFragment() {
  readFragment();
  showSettings();
  fillGrid();
  const alone = facts.models.length === 1 && !settings.model;
  const position = alone ? 0 : positionOf.get(settings.model);
  if (position !== undefined) {
    openModel(position);
  } else {
    if (settings.model) notice(`This page has no model \u2068${shortened(settings.model, 80)}\u2069.`);
    if (opened >= 0) closeModel();
    redraw();
  }
}

function watchControls() {
  const redrawWith = () => {
    showSettings();
    redraw();
    writeFragmentSoon();
  };
  byId('points').addEventListener('input', (event) => {
    settings.points = pointsOfSlider(Number(event.target.value));
    redrawWith();
  });
  byId('size').addEventListener('input', (event) => {
    settings.size = Number(event.target.value);
    redrawWith();
  });
  for (const name of ['color', 'style', 'up', 'detail', 'theme'])
    byId(name).addEventListener('change', (event) => {
      settings[name] = event.target.value;
      redrawWith();
    });
  for (const [name, kind] of [['text', 'input'], ['label', 'change'], ['sort', 'change']])
    byId(name).addEventListener(kind, (event) => {
      settings[name] = event.target.value;
      fillGrid();
      writeFragmentSoon();
    });
  byId('back').addEventListener('click', closeModel);
  byId('previous').addEventListener('click', () => step(-1));
  byId('next').addEventListener('click', () => step(1));
  byId('reset').addEventListener('click', resetView);
  watchPointers(byId('large'));
  window.addEventListener('keydown', pressedKey);
  window.addEventListener('resize', redraw);
  window.addEventListener('hashchange', applyFragment);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redrawWith);
}

function begin() {
  fillHead();
  fillFailures();
  fillRun();
  fillChoices();
  try {
    renderer = new Renderer();
    renderer.restored = redraw;
  } catch (error) {
    notice(`The models cannot be drawn: ${error.message}.`);
  }
  watchControls();
  applyFragment();
  drawAtOnce();
}

begin();
