// Points drawn with WebGL 2. One context serves the large view and all tiles, since browsers allow few: a model
// is drawn into a hidden canvas and copied from there.

const VERTEX_SHADER = `#version 300 es
precision highp float;
layout(location = 0) in vec3 place;    // in the box of the model, 0 to 1
layout(location = 1) in vec2 folded;   // octahedral normal, -1 to 1
layout(location = 2) in vec2 value;    // density and rank, 0 to 1
layout(location = 3) in vec3 paint;    // its own color, where look asks for it
uniform vec3 extent;                   // of the box, over half of its diagonal
uniform mat3 turn;
uniform vec3 lens;                     // magnification over half the width, over half the height; distance
uniform vec2 shift;                    // of the picture, in half heights
uniform float aspect;                  // width over height
uniform vec4 disc;                     // radius at density 1, lowest and highest density, 1: in logarithms
uniform vec3 look;                     // color: 0 plain, 1 density, 2 rank, 3 normal, 4 paint; 1: dots; pixels of half the height
uniform float push;                    // away from the eye, in radii
uniform float least;                   // radius in pixels of the smallest
uniform vec3 plain;
uniform vec4 thinning;                 // points over share (0: none are left out), least weight, fade (0: both sides), share
uniform sampler2D ramp;
flat out vec3 shade;
flat out vec3 facing;
flat out vec3 spot;                    // depth, radius in the model, half the pixels across
vec3 unfolded(vec2 f) {
  vec3 n = vec3(f, 1.0 - abs(f.x) - abs(f.y));
  float t = max(-n.z, 0.0);
  n.x += n.x >= 0.0 ? -t : t;
  n.y += n.y >= 0.0 ? -t : t;
  return normalize(n);
}
void main() {
  vec3 p = turn * ((place - 0.5) * extent);
  vec3 own = unfolded(folded);
  vec3 n = turn * own;
  vec3 eye = normalize(vec3(-p.xy, lens.z - p.z));
  float kept = 1.0;
  if (thinning.x > 0.0) {              // as viewDetail has it
    float facing = min(thinning.z > 0.0 ? n.z : abs(n.z), 1.0);
    float weight = thinning.y + (1.0 - thinning.y) * pow(max(1.0 - facing, 0.0), 4.0);
    if (facing <= 0.0) weight = thinning.z > 0.0 && n.z > -thinning.z ? pow(1.0 + n.z / thinning.z, 2.0) : 0.0;
    if (float(gl_VertexID) + 0.5 >= thinning.x * weight) {
      gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
      gl_PointSize = 1.0;
      return;
    }
    kept = clamp(thinning.w * weight, 1e-6, 1.0);
  }
  if (dot(n, eye) < 0.0) n = -n;
  float density = disc.w > 0.5 ? exp(mix(log(disc.y), log(disc.z), value.x)) : mix(disc.y, disc.z, value.x);
  float radius = disc.x * (look.y > 0.5 ? 1.0 : inversesqrt(max(density * kept, 1e-30)));
  float away = lens.z - p.z;
  gl_Position = vec4(lens.xy * p.xy + vec2(shift.x / aspect, shift.y) * away, -0.5 * p.z * away, away);
  float pixels = max(lens.y * radius / away * look.z, least);
  gl_PointSize = 2.0 * pixels + 1.0;
  vec3 color = plain;
  float dark = 0.48;                   // of a surface that faces away from the light; values stay readable
  if (look.x > 0.5 || push > 0.0) dark = 0.7;
  if (look.x > 3.5) color = paint;
  else if (look.x > 2.5) color = 0.5 + 0.42 * own;
  else if (look.x > 0.5) color = textureLod(ramp, vec2((look.x > 1.5 ? value.y : value.x) * 255.0 / 256.0 + 0.5 / 256.0, 0.5), 0.0).rgb;
  float light = max(dot(n, normalize(vec3(-0.3, 0.5, 0.8))), 0.0);
  shade = min(color * (dark + (1.1 - dark) * light), 1.0);
  facing = vec3(n.xy, max(n.z, clamp(0.9 * least / pixels, 0.12, 1.0)));  // a pixel wide at least
  spot = vec3(0.5 - 0.25 * p.z + 0.25 * push * radius, 0.25 * radius, pixels);
}`;

const FRAGMENT_SHADER = `#version 300 es
precision highp float;
flat in vec3 shade;
flat in vec3 facing;
flat in vec3 spot;
uniform vec3 look;
out vec4 color;
void main() {
  vec2 at = (gl_PointCoord - 0.5) * vec2(2.0, -2.0) * (spot.z + 0.5) / spot.z;  // 1 on the rim
  float lift = look.y > 0.5 ? 0.0 : -dot(facing.xy, at) / facing.z;
  float from = sqrt(dot(at, at) + lift * lift);
  if (from > 1.0) discard;
  gl_FragDepth = spot.x - lift * spot.y;
  color = vec4(shade, 1.0);
}`;

// The color map of values: dark violet over blue and green to yellow, in even steps of OKLab lightness, as in
// the pictures of the program.
function lagoonColor(t) {
  const s = 2 * t - 1;
  const chroma = 0.094 + s * s * (0.065 + 0.025 * s);
  const hue = ((305 + (108 - 305) * t) * Math.PI) / 180;
  const [lightness, a, b] = [0.28 + 0.64 * t, chroma * Math.cos(hue), chroma * Math.sin(hue)];
  return fromOklab(lightness, a, b);
}

// sRGB, 0 to 255; colors outside are clamped.
function fromOklab(lightness, a, b) {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const n = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * n,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * n,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * n,
  ];
  return linear.map((v) => {
    const encoded = v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055;
    return Math.round(255 * Math.min(1, Math.max(0, encoded)));
  });
}

// The colors of classes, by number, as in the pictures of the program: ten that stay apart for the color-blind, then
// hues in steps of the golden angle in three lightnesses.
const PALETTE = [[0x00, 0x72, 0xB2], [0xD5, 0x5E, 0x00], [0x00, 0x9E, 0x73], [0xCC, 0x79, 0xA7], [0xE6, 0x9F, 0x00],
                 [0x56, 0xB4, 0xE9], [0x00, 0x00, 0x00], [0x33, 0x22, 0x88], [0x88, 0x22, 0x55], [0x8C, 0x51, 0x0A]];
const NO_VALUE = [150, 150, 150];
function classColor(number) {
  if (number < 0) return NO_VALUE;
  if (number < PALETTE.length) return PALETTE[number];
  const further = number - PALETTE.length;
  const turn = (further * (3 - Math.sqrt(5))) / 2;
  const hue = 2 * Math.PI * (turn - Math.floor(turn));
  return fromOklab([0.52, 0.70, 0.38][further % 3], 0.11 * Math.cos(hue), 0.11 * Math.sin(hue));
}

// The color of each point of a model, 4 bytes each: of the coloring with this word, or by the class of the model.
function paintOf(position, word) {
  const paint = new Uint8Array(4 * facts.points).fill(255);
  const c = facts.colorings.findIndex((coloring) => coloring.word === word);
  const bytes = c < 0 ? null : blockOf(position).subarray(coloringBegin(c), coloringBegin(c + 1));
  const kind = c < 0 ? 'label' : facts.colorings[c].kind;
  const known = new Map();  // colors of values
  for (let i = 0; i < facts.points; ++i) {
    if (kind === 'colors') {
      paint.set(bytes.subarray(3 * i, 3 * i + 3), 4 * i);
      continue;
    }
    const value = kind === 'number' ? bytes[i] : kind === 'classes' ? bytes[2 * i] + 256 * bytes[2 * i + 1] : 0;
    let color = known.get(value);
    if (!color) {
      if (kind === 'number') color = value === 255 ? NO_VALUE : lagoonColor(value / 254);
      else if (kind === 'classes') color = value === 65535 ? NO_VALUE : classColor(value);
      else color = classColor(facts.models[position].label);
      known.set(value, color);
    }
    paint.set(color, 4 * i);
  }
  return paint;
}

function compiled(gl, kind, source) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
  return shader;
}

// The rotation that brings the model's up axis up, then turns it about it and tips it towards the reader.
// Column by column.
function turnMatrix(yaw, pitch, up) {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const turned = (x, y, z) => {
    const [tx, tz] = [cy * x + sy * z, -sy * x + cy * z];
    return [tx, cp * y - sp * tz, sp * y + cp * tz];
  };
  const axes = up === 'z' ? [[1, 0, 0], [0, 0, -1], [0, 1, 0]] : [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  return axes.flatMap((axis) => turned(...axis));
}

const EYE_DISTANCE = 4.4;  // in half diagonals of the box
const WIDEST_REACH = 1.6;  // of a box; sheets upon sheets have more area than can be seen
const BUFFERS_KEPT = 48;
const COLORS = ['plain', 'density', 'rank', 'normal'];  // what every point has; the others are paint
// Radii of discs over those of discs that have the area of the surface together: discs that leave no gaps, and discs
// of 0.26 of the spacing of the samples, the root of their share of the surface, as on the sheets of `render`.
const COVERING = 1.8;
const SURFACE_POINTS = 20000;  // make a surface that is fine enough for samples to lie on
const APART = 0.26 * Math.sqrt(Math.PI);

class Renderer {
  // Throws where the browser has no WebGL 2.
  constructor() {
    this.canvas = document.createElement('canvas');
    this.canvas.width = this.canvas.height = 16;
    this.gl = this.canvas.getContext('webgl2', {antialias: false, alpha: false, depth: true, stencil: false});
    if (!this.gl) throw new Error('this browser has no WebGL 2');
    this.canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    this.canvas.addEventListener('webglcontextrestored', () => {
      this.prepare();
      this.restored?.();
    });
    this.prepare();
  }

  prepare() {
    const gl = this.gl;
    this.buffers = new Map();  // of models, most recently used last
    const program = gl.createProgram();
    gl.attachShader(program, compiled(gl, gl.VERTEX_SHADER, VERTEX_SHADER));
    gl.attachShader(program, compiled(gl, gl.FRAGMENT_SHADER, FRAGMENT_SHADER));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    gl.useProgram(program);
    this.uniforms = {};
    for (const name of ['extent', 'turn', 'lens', 'shift', 'aspect', 'disc', 'look', 'least', 'plain', 'push', 'ramp', 'thinning'])
      this.uniforms[name] = gl.getUniformLocation(program, name);
    const ramp = new Uint8Array(256 * 4);
    for (let i = 0; i < 256; ++i) ramp.set([...lagoonColor(i / 255), 255], 4 * i);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, ramp);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.LINEAR);
    for (const way of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, way, gl.CLAMP_TO_EDGE);
    gl.uniform1i(this.uniforms.ramp, 0);
    this.widest = Math.min(8192, gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), ...gl.getParameter(gl.MAX_VIEWPORT_DIMS));
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SCISSOR_TEST);
  }

  // word: of the coloring that the points are painted by; null: none.
  bindModel(position, word) {
    const gl = this.gl;
    let array = this.buffers.get(position);
    if (array) {
      this.buffers.delete(position);
      gl.bindVertexArray(array.vertices);
    } else {
      array = {vertices: gl.createVertexArray(), buffer: gl.createBuffer(), paint: null, word: null};
      gl.bindVertexArray(array.vertices);
      gl.bindBuffer(gl.ARRAY_BUFFER, array.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, pointsOf(position), gl.STATIC_DRAW);
      for (const i of [0, 1, 2]) gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(0, 3, gl.UNSIGNED_SHORT, true, POINT_BYTES, 0);
      gl.vertexAttribPointer(1, 2, gl.BYTE, true, POINT_BYTES, 6);
      gl.vertexAttribPointer(2, 2, gl.UNSIGNED_BYTE, true, POINT_BYTES, 8);
    }
    if (word !== null && word !== array.word) {
      array.paint ??= gl.createBuffer();
      array.word = word;
      gl.bindBuffer(gl.ARRAY_BUFFER, array.paint);
      gl.bufferData(gl.ARRAY_BUFFER, paintOf(position, word), gl.STATIC_DRAW);
      gl.enableVertexAttribArray(3);
      gl.vertexAttribPointer(3, 3, gl.UNSIGNED_BYTE, true, 4, 0);
    }
    this.buffers.set(position, array);
    if (this.buffers.size <= BUFFERS_KEPT) return;
    const [oldest, old] = this.buffers.entries().next().value;
    gl.deleteVertexArray(old.vertices);
    gl.deleteBuffer(old.buffer);
    if (old.paint) gl.deleteBuffer(old.paint);
    this.buffers.delete(oldest);
  }

  // Radius at density 1, over half the diagonal: `share` times that of discs that have the area of the surface together.
  // Dots have one size that goes with the number alone.
  discOf(model, count, style, scale, share) {
    const [low, high] = model.density;
    if (style === 'dots' || !(model.reach > 0)) return [share * Math.min(0.045, 0.42 / Math.sqrt(count)), 1, 1, 0];
    return [(share * Math.min(model.reach / scale, WIDEST_REACH)) / Math.sqrt(count), low, high, low > 0 ? 1 : 0];
  }

  // Draws the first points into the upper left width x height pixels of the hidden canvas, none smaller than
  // `least` pixels. how: {points, color, style, size, up, detail}; `kept` tells how many it drew; view: {yaw, pitch,
  // zoom, x, y}; theme: {stage, plain, sample}, 0 to 1. Of the style `discs` a surface of points is drawn first,
  // which hides what lies behind, and then the samples on it, small enough to be told apart.
  draw(position, width, height, how, view, theme, least) {
    const gl = this.gl;
    const canvas = this.canvas;
    if (canvas.width < width || canvas.height < height) {
      canvas.width = Math.max(canvas.width, width);
      canvas.height = Math.max(canvas.height, height);
    }
    const model = facts.models[position];
    const extent = model.high.map((high, axis) => high - model.low[axis]);
    const scale = Math.hypot(...extent) / 2 || 1;
    const count = Math.max(1, Math.min(facts.points, how.points));
    const aspect = width / height;
    const magnified = (view.zoom * Math.sqrt(EYE_DISTANCE * EYE_DISTANCE - 1)) / Math.max(1, 1 / aspect);
    gl.viewport(0, canvas.height - height, width, height);
    gl.scissor(0, canvas.height - height, width, height);
    gl.clearColor(...theme.stage, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const builtIn = COLORS.indexOf(how.color);
    const isPainted = builtIn < 0 || facts.colorings.some((coloring) => coloring.word === how.color);
    this.bindModel(position, isPainted ? how.color : null);
    gl.uniform3fv(this.uniforms.extent, extent.map((e) => e / scale));
    const turn = turnMatrix(view.yaw, view.pitch, how.up);
    gl.uniformMatrix3fv(this.uniforms.turn, false, turn);
    const detail = how.detail === 'view' && onlyPrefixes ? viewDetail(position, count, [turn[2], turn[5], turn[8]]) : null;
    this.kept = detail ? detail.kept : count;
    gl.uniform3f(this.uniforms.lens, magnified / aspect, magnified, EYE_DISTANCE);
    gl.uniform2f(this.uniforms.shift, view.x, view.y);
    gl.uniform1f(this.uniforms.aspect, aspect);
    gl.uniform1f(this.uniforms.least, least);
    const isDots = how.style === 'dots' || !(model.reach > 0);
    const isApart = how.style === 'discs' && !isDots;
    if (isApart) {
      gl.uniform4f(this.uniforms.thinning, 0, 0, 0, 1);
      const covering = onlyPrefixes ? Math.min(facts.points, SURFACE_POINTS) : facts.points;
      gl.uniform4fv(this.uniforms.disc, this.discOf(model, covering, how.style, scale, COVERING));
      gl.uniform3f(this.uniforms.look, 0, 0, height / 2);
      gl.uniform1f(this.uniforms.push, 0.5);
      gl.uniform3fv(this.uniforms.plain, theme.plain);
      gl.drawArrays(gl.POINTS, 0, covering);
    }
    if (detail) gl.uniform4f(this.uniforms.thinning, detail.share * count, LEAST_WEIGHT, detail.closed ? FADE : 0, detail.share);
    else gl.uniform4f(this.uniforms.thinning, 0, 0, 0, 1);
    const share = how.size * (isDots ? 1 : isApart ? APART : COVERING);
    gl.uniform4fv(this.uniforms.disc, this.discOf(model, count, how.style, scale, share));
    gl.uniform3f(this.uniforms.look, isPainted ? COLORS.length : builtIn, isDots ? 1 : 0, height / 2);
    gl.uniform1f(this.uniforms.push, 0);
    gl.uniform3fv(this.uniforms.plain, isApart ? theme.sample : theme.plain);
    gl.drawArrays(gl.POINTS, 0, count);
  }

  // The same, onto a canvas on the page, which gets this size. Smooth rims are means of 2 x 2 pixels, since
  // multisampling costs twice as much in software; `quick` leaves them out.
  paint(target, position, width, height, how, view, theme, quick) {
    const fine = quick || 2 * Math.max(width, height) > this.widest ? 1 : 2;
    this.draw(position, fine * width, fine * height, how, view, theme, fine);
    if (target.width !== width || target.height !== height) {
      target.width = width;
      target.height = height;
    }
    target.getContext('2d', {alpha: false}).drawImage(this.canvas, 0, 0, fine * width, fine * height, 0, 0, width, height);
  }
}
