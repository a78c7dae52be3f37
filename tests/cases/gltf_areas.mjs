// For peer_check.py: area, box and number of the triangles of glTF files, as glTF-Transform reads them.
// usage: node gltf_areas.mjs NODE_MODULES NAMES.json; a line of JSON for each: [path, area, box, triangles], or
// [path, null, reason].
import { createRequire } from "module";
import { readFileSync } from "fs";
import { resolve } from "path";
import { pathToFileURL } from "url";

const [modules, names] = process.argv.slice(2);
const require = createRequire(pathToFileURL(resolve(modules, "..", "from-here.js")));
const load = async (name) => import(pathToFileURL(require.resolve(name)).href);
const { NodeIO } = await load("@gltf-transform/core").then((core) => core.default ?? core);
const { ALL_EXTENSIONS } = await load("@gltf-transform/extensions").then((all) => all.default ?? all);
const { MeshoptDecoder } = await load("meshoptimizer");
const draco = (await load("draco3dgltf")).default;
await MeshoptDecoder.ready;
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
  "meshopt.decoder": MeshoptDecoder,
  "draco3d.decoder": await draco.createDecoderModule(),
});

// Column-major 4 x 4 matrices.
const product = (a, b) => {
  const m = new Array(16).fill(0);
  for (let c = 0; c < 4; ++c)
    for (let r = 0; r < 4; ++r) for (let k = 0; k < 4; ++k) m[4 * c + r] += a[4 * k + r] * b[4 * c + k];
  return m;
};
const moved = (m, p) => [0, 1, 2].map((r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);
const placed = (t, [x, y, z, w], s) => [
  (1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y + z * w) * s[0], 2 * (x * z - y * w) * s[0], 0,
  2 * (x * y - z * w) * s[1], (1 - 2 * (x * x + z * z)) * s[1], 2 * (y * z + x * w) * s[1], 0,
  2 * (x * z + y * w) * s[2], 2 * (y * z - x * w) * s[2], (1 - 2 * (x * x + y * y)) * s[2], 0, ...t, 1];
const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

function measure(document) {
  let area = 0, triangles = 0;
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  const add = (a, b, c) => {
    if (![...a, ...b, ...c].every(Number.isFinite)) return;
    ++triangles;
    const u = b.map((v, k) => v - a[k]), v = c.map((w, k) => w - a[k]);
    const twice = Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
    if (!(twice > 0)) return;
    area += twice / 2;
    for (const p of [a, b, c])
      for (let k = 0; k < 3; ++k) {
        low[k] = Math.min(low[k], p[k]);
        high[k] = Math.max(high[k], p[k]);
      }
  };
  const primitive = (part, weights, place) => {
    const positions = part.getAttribute("POSITION");
    if (!positions || part.getMode() < 4) return;
    const targets = part.listTargets().map((target) => target.getAttribute("POSITION"));
    const points = [];
    for (let v = 0; v < positions.getCount(); ++v) {
      const p = positions.getElement(v, []).slice(0, 3);
      targets.forEach((target, t) => target && weights[t] &&
        target.getElement(v, []).forEach((move, k) => (p[k] += weights[t] * move)));
      points.push(place(p, v));
    }
    const indices = part.getIndices();
    const count = indices ? indices.getCount() : points.length;
    const at = (k) => points[indices ? indices.getScalar(k) : k];
    const step = part.getMode() === 4 ? 3 : 1;
    for (let k = 0; k + 2 < count; k += step) {
      const corners = part.getMode() === 6 ? [at(0), at(k + 1), at(k + 2)] : [at(k), at(k + 1), at(k + 2)];
      if (corners.every(Boolean)) add(...corners);
    }
  };
  const visit = (node, hidden) => {
    const visibility = node.getExtension("KHR_node_visibility");
    hidden = hidden || (visibility && visibility.getVisible && !visibility.getVisible());
    const mesh = node.getMesh(), world = node.getWorldMatrix(), skin = node.getSkin();
    const instancing = node.getExtension("EXT_mesh_gpu_instancing");
    if (mesh && !hidden) {
      let worlds = [world];
      if (instancing) {
        const get = (name, otherwise, k) => instancing.getAttribute(name)?.getElement(k, []) ?? otherwise;
        const count = instancing.listAttributes()[0]?.getCount() ?? 0;
        worlds = [...Array(count).keys()].map((k) => product(world,
          placed(get("TRANSLATION", [0, 0, 0], k), get("ROTATION", [0, 0, 0, 1], k), get("SCALE", [1, 1, 1], k))));
      }
      const own = node.getWeights().length ? node.getWeights() : mesh.getWeights();
      for (const part of mesh.listPrimitives()) {
        const sets = [0, 1, 2, 3].map((s) => [part.getAttribute(`JOINTS_${s}`), part.getAttribute(`WEIGHTS_${s}`)])
          .filter(([joints, weights]) => joints && weights);
        if (skin && sets.length) {
          const inverse = skin.getInverseBindMatrices();
          const joints = skin.listJoints().map((joint, j) =>
            product(joint.getWorldMatrix(), inverse ? inverse.getElement(j, []) : identity));
          primitive(part, own, (p, v) => {
            const sum = [0, 0, 0];
            let total = 0;
            for (const [numbers, weights] of sets) {
              const number = numbers.getElement(v, []), weight = weights.getElement(v, []);
              weight.forEach((w, k) => {
                if (!w || !joints[number[k]]) return;
                total += w;
                moved(joints[number[k]], p).forEach((value, axis) => (sum[axis] += w * value));
              });
            }
            return total > 0 ? sum.map((value) => value / total) : moved(world, p);
          });
        } else {
          for (const matrix of worlds) primitive(part, own, (p) => moved(matrix, p));
        }
      }
    }
    node.listChildren().forEach((child) => visit(child, hidden));
  };
  const root = document.getRoot();
  const scene = root.getDefaultScene() ?? root.listScenes()[0];
  if (scene) scene.listChildren().forEach((node) => visit(node, false));
  else root.listNodes().filter((node) => !node.getParentNode()).forEach((node) => visit(node, false));
  return [area, triangles && low[0] <= high[0] ? [...low, ...high] : [], triangles];
}

for (const path of JSON.parse(readFileSync(names))) {
  try {
    console.log(JSON.stringify([path, ...measure(await io.read(path))]));
  } catch (error) {
    console.log(JSON.stringify([path, null, String(error).slice(0, 200)]));
  }
}
