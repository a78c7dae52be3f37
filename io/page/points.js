// The data of the page: the facts of all models, and their points, decoded when they are first needed.
// Layout of a block: io/page/model_page.h.

const POINT_BYTES = 10;

const facts = JSON.parse(document.getElementById('facts').textContent);

// Blocks of models, most recently used last: at most KEPT_BYTES of them stay decoded.
const KEPT_BYTES = 64 << 20;
const decodedBlocks = new Map();
let decodedBytes = 0;

function blockOf(position) {
  let block = decodedBlocks.get(position);
  if (block) {
    decodedBlocks.delete(position);
  } else {
    const text = atob(document.getElementById('model-' + position).textContent);
    block = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) block[i] = text.charCodeAt(i);
    decodedBytes += block.length;
  }
  decodedBlocks.set(position, block);
  for (const [oldest, bytes] of decodedBlocks) {
    if (decodedBytes <= KEPT_BYTES || oldest === position) break;
    decodedBlocks.delete(oldest);
    decodedBytes -= bytes.length;
  }
  return block;
}

function pointsOf(position) {
  return blockOf(position).subarray(0, facts.points * POINT_BYTES);
}

// Where the values of coloring number c begin in a block; behind the last one are the histograms.
function coloringBegin(c) {
  let at = facts.points * POINT_BYTES;
  for (let i = 0; i < c; ++i) at += facts.points * facts.colorings[i].bytes;
  return at;
}

// The bins of histogram number h over their largest, 0 to 1; null where the model has none.
function histogramOf(position, h) {
  if (facts.models[position].peaks[h] === null) return null;
  let at = coloringBegin(facts.colorings.length);
  for (let i = 0; i < h; ++i) at += facts.histograms[i].width;
  return Array.from(blockOf(position).subarray(at, at + facts.histograms[h].width), (byte) => byte / 255);
}

function labelOf(model) {
  return model.label >= 0 ? facts.labels[model.label] ?? '' : '';
}

// The end of a long text, where names differ, with an ellipsis in front; whole characters only.
function shortened(text, most) {
  const characters = Array.from(text);
  return characters.length <= most ? text : '\u2026' + characters.slice(characters.length - most + 1).join('');
}

function formatted(number) {
  if (number === null || number === undefined) return '\u2013';
  if (Number.isInteger(number) && Math.abs(number) < 1e15) return number.toLocaleString('en');
  return String(Number(number.toPrecision(5)));
}

// Three digits, where a legend has little room.
function brief(number) {
  return String(Number(number.toPrecision(3)));
}
