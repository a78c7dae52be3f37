// Points for one direction of view: dense along the silhouette, few where the model faces the eye. All views thin one
// progressive set, so that points come and go while a model turns, but never move: kernels/render/view_detail.h.

const LEAST_WEIGHT = 0.1;  // of a point that faces the eye, that of the silhouette being 1
const FADE = 0.35;         // behind the silhouette, none are left from this cosine on

const onlyPrefixes = facts.order === 'progressive';  // other orders have nothing to thin

function unfolded(x, y) {
  let z = 1 - Math.abs(x) - Math.abs(y);
  const t = Math.max(-z, 0);
  [x, y] = [x + (x >= 0 ? -t : t), y + (y >= 0 ? -t : t)];
  const length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}

// Normals and areas of the points of a model, and whether it is closed with normals that point outwards: then
// nothing that faces away can be seen. Kept for the model seen last.
let shapeSeen = {position: -1};
function shapeOf(position) {
  if (shapeSeen.position === position) return shapeSeen;
  const bytes = pointsOf(position);
  const values = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const model = facts.models[position];
  const [low, high] = model.density;
  const normals = new Float32Array(3 * facts.points);
  const areas = new Float32Array(facts.points);
  let volume = 0;
  for (let i = 0; i < facts.points; ++i) {
    const at = i * POINT_BYTES;
    const normal = unfolded(Math.max(-1, values.getInt8(at + 6) / 127), Math.max(-1, values.getInt8(at + 7) / 127));
    normals.set(normal, 3 * i);
    const place = bytes[at + 8] / 255;
    areas[i] = 1 / Math.max(1e-30, low > 0 ? low * (high / low) ** place : low + (high - low) * place);
    for (let axis = 0; axis < 3; ++axis) {
      const p = (values.getUint16(at + 2 * axis, true) / 65535 - 0.5) * (model.high[axis] - model.low[axis]);
      volume += areas[i] * p * normal[axis];
    }
  }
  shapeSeen = {position, normals, areas, closed: model.components > 0 && model.boundaries === 0 && volume > 0};
  return shapeSeen;
}

function viewWeight(cosine, closed) {
  const facing = Math.min(1, closed ? cosine : Math.abs(cosine));
  if (facing > 0) return LEAST_WEIGHT + (1 - LEAST_WEIGHT) * (1 - facing) ** 4;
  return closed && cosine > -FADE ? (1 + cosine / FADE) ** 2 : 0;
}

// A point i of the first `count` is kept where (i + 1/2) / count < share x weight. The share makes the number of
// points go with the area that the model shows; on the mean over all directions the silhouette has them all.
// towards: unit, from the model to the eye.
function viewDetail(position, count, towards) {
  const shape = shapeOf(position);
  const front = LEAST_WEIGHT + (1 - LEAST_WEIGHT) / 5;  // means over all directions
  const [meanWeight, meanFacing] = shape.closed ? [(front + FADE / 3) / 2, 0.25] : [front, 0.5];
  const weights = new Float32Array(count);
  let [weight, projected, area] = [0, 0, 0];
  for (let i = 0; i < count; ++i) {
    const n = shape.normals;
    const cosine = n[3 * i] * towards[0] + n[3 * i + 1] * towards[1] + n[3 * i + 2] * towards[2];
    weights[i] = viewWeight(cosine, shape.closed);
    weight += weights[i];
    projected += shape.areas[i] * Math.max(0, shape.closed ? cosine : Math.abs(cosine));
    area += shape.areas[i];
  }
  if (!(weight > 0) || !(projected > 0)) return {share: 0, closed: shape.closed, kept: count};
  const share = ((count * meanWeight) / (area * meanFacing)) * (projected / weight);
  let kept = 0;
  for (let i = 0; i < count; ++i) kept += (i + 0.5) / count < share * weights[i];
  return {share, closed: shape.closed, kept};
}
