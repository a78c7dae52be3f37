// Points drawn with WebGL 2. One context serves the large view and all tiles, since browsers allow few: a model
// is drawn into a hidden canvas and copied from there.

const VERTEX_SHADER = `#version 300 es
precision highp float;
layout(location = 0) in vec3 place;    // in the box of the model, 0 to 1
layout(location = 1) in vec2 folded;   // octahedral normal, -1 to 1
layout(location = 2) in vec2 value;    // density and rank, 0 to 1
uniform vec3 extent;                   // of the box, over half of its diagonal
uniform mat3 turn;
uniform vec3 lens;                     // magnification over half the width, over half the height; distance
uniform vec2 shift;                    // of the picture, in half heights
uniform float aspect;                  // width over height
uniform vec4 disc;                     // radius at density 1, lowest and highest density, 1: in logarithms
uniform vec3 look;                     // colour: 0 plain, 1 density, 2 rank, 3 normal; 1: dots; pixels of half the height
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
  vec3 colour = plain;
  float dark = 0.48;                   // of a surface that faces away from the light; values stay readable
  if (look.x > 0.5) dark = 0.7;
  if (look.x > 2.5) colour = 0.5 + 0.42 * own;
  else if (look.x > 0.5) colour = textureLod(ramp, vec2((look.x > 1.5 ? value.y : value.x) * 255.0 / 256.0 + 0.5 / 256.0, 0.5), 0.0).rgb;
  float light = max(dot(n, normalize(vec3(-0.3, 0.5, 0.8))), 0.0);
  shade = min(colour * (dark + (1.1 - dark) * light), 1.0);
  facing = vec3(n.xy, max(n.z, clamp(0.9 * least / pixels, 0.12, 1.0)));  // a pixel wide at least
  spot = vec3(0.5 - 0.25 * p.z, 0.25 * radius, pixels);
}`;

const FRAGMENT_SHADER = `#version 300 es
precision highp float;
flat in vec3 shade;
flat in vec3 facing;
flat in vec3 spot;
uniform vec3 look;
out vec4 colour;
void main() {
  vec2 at = (gl_PointCoord - 0.5) * vec2(2.0, -2.0) * (spot.z + 0.5) / spot.z;  // 1 on the rim
  float lift = look.y > 0.5 ? 0.0 : -dot(facing.xy, at) / facing.z;
  float from = sqrt(dot(at, at) + lift * lift);
  if (from > 1.0) discard;
  gl_FragDepth = spot.x - lift * spot.y;
  colour = vec4(shade, 1.0);
}`;

// The colour map of values: dark violet over blue and green to yellow, in even steps of OKLab lightness, as in
// the pictures of the program.
function lagoonColour(t) {
  const s = 2 * t - 1;
  const chroma = 0.094 + s * s * (0.065 + 0.025 * s);
  const hue = ((305 + (108 - 305) * t) * Math.PI) / 180;
  const [lightness, a, b] = [0.28 + 0.64 * t, chroma * Math.cos(hue), chroma * Math.sin(hue)];
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
    for (const name of ['extent', 'turn', 'lens', 'shift', 'aspect', 'disc', 'look', 'least', 'plain', 'ramp', 'thinning'])
      this.uniforms[name] = gl.getUniformLocation(program, name);
    const ramp = new Uint8Array(256 * 4);
    for (let i = 0; i < 256; ++i) ramp.set([...lagoonColour(i / 255), 255], 4 * i);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, ramp);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.LINEAR);
    for (const way of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, way, gl.CLAMP_TO_EDGE);
    gl.uniform1i(this.uniforms.ramp, 0);
    this.widest = Math.min(8192, gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), ...gl.getParameter(gl.MAX_VIEWPORT_DIMS));
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SCISSOR_TEST);
  }

  bindModel(position) {
    const gl = this.gl;
    let array = this.buffers.get(position);
    if (array) {
      this.buffers.delete(position);
      gl.bindVertexArray(array.vertices);
    } else {
      array = {vertices: gl.createVertexArray(), buffer: gl.createBuffer()};
      gl.bindVertexArray(array.vertices);
      gl.bindBuffer(gl.ARRAY_BUFFER, array.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, pointsOf(position), gl.STATIC_DRAW);
      for (const i of [0, 1, 2]) gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(0, 3, gl.UNSIGNED_SHORT, true, POINT_BYTES, 0);
      gl.vertexAttribPointer(1, 2, gl.BYTE, true, POINT_BYTES, 6);
      gl.vertexAttribPointer(2, 2, gl.UNSIGNED_BYTE, true, POINT_BYTES, 8);
    }
    this.buffers.set(position, array);
    if (this.buffers.size <= BUFFERS_KEPT) return;
    const [oldest, old] = this.buffers.entries().next().value;
    gl.deleteVertexArray(old.vertices);
    gl.deleteBuffer(old.buffer);
    this.buffers.delete(oldest);
  }

  // Radius at density 1: 1.8 times that of discs that have the area of the surface together, since discs leave
  // gaps. Dots have one size that goes with the number alone.
  discOf(model, count, how, scale) {
    const [low, high] = model.density;
    if (how.style === 'dots' || !(model.reach > 0))
      return [how.size * Math.min(0.045, 0.42 / Math.sqrt(count)), 1, 1, 0];
    return [(1.8 * how.size * Math.min(model.reach / scale, WIDEST_REACH)) / Math.sqrt(count), low, high, low > 0 ? 1 : 0];
  }

  // Draws the first points into the upper left width x height pixels of the hidden canvas, none smaller than
  // `least` pixels. how: {points, colour, style, size, up, detail}; `kept` tells how
  // many it drew; view: {yaw, pitch, zoom, x, y}; theme: {stage,
  // plain}, 0 to 1.
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
    this.bindModel(position);
    gl.uniform3fv(this.uniforms.extent, extent.map((e) => e / scale));
    const turn = turnMatrix(view.yaw, view.pitch, how.up);
    gl.uniformMatrix3fv(this.uniforms.turn, false, turn);
    const detail = how.detail === 'view' && onlyPrefixes ? viewDetail(position, count, [turn[2], turn[5], turn[8]]) : null;
    this.kept = detail ? detail.kept : count;
    if (detail) gl.uniform4f(this.uniforms.thinning, detail.share * count, LEAST_WEIGHT, detail.closed ? FADE : 0, detail.share);
    else gl.uniform4f(this.uniforms.thinning, 0, 0, 0, 1);
    gl.uniform3f(this.uniforms.lens, magnified / aspect, magnified, EYE_DISTANCE);
    gl.uniform2f(this.uniforms.shift, view.x, view.y);
    gl.uniform1f(this.uniforms.aspect, aspect);
    gl.uniform4fv(this.uniforms.disc, this.discOf(model, count, how, scale));
    const colour = ['plain', 'density', 'rank', 'normal'].indexOf(how.colour);
    gl.uniform3f(this.uniforms.look, colour, how.style === 'dots' ? 1 : 0, height / 2);
    gl.uniform1f(this.uniforms.least, least);
    gl.uniform3fv(this.uniforms.plain, theme.plain);
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
