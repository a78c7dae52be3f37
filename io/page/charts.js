// What stands beside a model: tables of values and histograms.

// An element with its text; nothing of the store is ever parsed as markup.
function element(tag, text, name) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (name) made.className = name;
  return made;
}

function isolated(text) {
  const made = element('bdi', text);
  made.dir = 'auto';
  return made;
}

// [term, value or element] pairs; those without a value are left out.
function fillList(list, pairs) {
  list.replaceChildren();
  for (const [term, value, title] of pairs) {
    if (value === undefined || value === null || value === '') continue;
    const dt = element('dt', term);
    if (title) dt.title = title;
    const dd = document.createElement('dd');
    dd.append(value instanceof Node ? value : isolated(String(value)));
    list.append(dt, dd);
  }
  return list;
}

function svgElement(tag, attributes, text) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

// shares: heights over the largest bin; peak: that of the largest.
function histogramChart(shares, peak, title) {
  const [width, height, left, top, bottom] = [380, 110, 4, 16, 16];
  const chart = svgElement('svg', {viewBox: `0 0 ${width} ${height}`, class: 'histogram', role: 'img'});
  chart.append(svgElement('title', {}, title));
  const base = height - bottom;
  const step = (width - 2 * left) / shares.length;
  let path = `M${left} ${base}`;
  shares.forEach((share, i) => {
    const y = (base - share * (base - top)).toFixed(1);
    path += `V${y}H${(left + (i + 1) * step).toFixed(2)}`;
  });
  chart.append(svgElement('path', {d: path + `V${base}Z`, class: 'area'}));
  chart.append(svgElement('path', {d: `M${left} ${base}H${width - left}`, class: 'axis'}));
  chart.append(svgElement('text', {x: left, y: 11}, 'largest bin ' + formatted(peak)));
  chart.append(svgElement('text', {x: left, y: height - 3}, 'bin 1'));
  chart.append(svgElement('text', {x: width - left, y: height - 3, 'text-anchor': 'end'}, String(shares.length)));
  return chart;
}

// Values of the model, one list for each group: certificates, what its charts came to, descriptors without bins.
const GROUP_NAMES = {certificate: 'Certificate', anisotropy: 'Charts', descriptors: 'Values'};

function valueLists(model) {
  const groups = new Map();
  let at = 0;
  for (const schema of facts.values) {
    const columns = schema.columns ? schema.columns.split(',') : [];
    for (let i = 0; i < schema.width; ++i, ++at) {
      const name = schema.width > 1 ? columns[i] ?? String(i) : schema.name;
      if (!groups.has(schema.group)) groups.set(schema.group, []);
      groups.get(schema.group).push([name.replaceAll('_', ' '), formatted(model.values[at]), schema.value]);
    }
  }
  return [...groups].flatMap(([group, pairs]) =>
    [element('h3', GROUP_NAMES[group] ?? group), fillList(document.createElement('dl'), pairs)]);
}

function sizeText(model) {
  return model.size.map(formatted).join(' \u00d7 ');
}

function geometryList(model) {
  const topology = `${formatted(model.components)} component${model.components === 1 ? '' : 's'}, genus ` +
    `${formatted(model.genus)}, ${formatted(model.boundaries)} boundary loop${model.boundaries === 1 ? '' : 's'}`;
  const isMesh = facts.content !== 'surfaces';
  return fillList(document.createElement('dl'), [
    ['label', labelOf(model)],
    ['split', model.split],
    ['method', isMesh ? model.method : ''],
    ['vertices', isMesh ? formatted(model.vertices) : ''],
    ['faces', isMesh ? formatted(model.faces) : ''],
    ['topology', isMesh ? topology : ''],
    ['area', formatted(model.area)],
    ['box', sizeText(model)],
    ['density', [...new Set(model.density.map(formatted))].join(' to ')],
    ['colors', colorsText(model)],
    ['row', formatted(model.row)],
  ]);
}

// Where the colors of the samples come from.
function colorsText(model) {
  if (model.color_source === undefined) return '';
  const source = model.color_source === 'none' ? 'none in the file' : 'of its ' + COLOR_SOURCES[model.color_source];
  return model.color_fills > 0 ? `${source}; gray at ${formatted(model.color_fills)} of ${formatted(facts.samples)} points` : source;
}
const COLOR_SOURCES = {material: 'materials', face: 'faces', vertex: 'vertices', texture: 'textures'};

// What the file asks for and did not get.
function noteParts(model) {
  if (!model.notes) return [];
  return [element('h3', 'Notes'), ...model.notes.split('; ').map((note) => {
    const line = element('p', undefined, 'note');
    line.append(isolated(note.replaceAll('_', ' ')));
    return line;
  })];
}

function histogramCharts(position) {
  const parts = [];
  facts.histograms.forEach((histogram, h) => {
    const shares = histogramOf(position, h);
    if (!shares) return;
    const heading = element('h3', 'Histogram ' + histogram.name);
    heading.title = [histogram.value, histogram.bins].filter(Boolean).join('; ');
    parts.push(heading, histogramChart(shares, facts.models[position].peaks[h], histogram.name));
  });
  return parts;
}
