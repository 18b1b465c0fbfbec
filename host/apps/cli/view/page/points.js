'use strict';
// Returns as points, boxes, the trajectory and the cameras with WebGL; names and measures above them.

const kPointValues = 7;  // x y z intensity ring time actor

// Colours of increasing lightness, distinguishable by colour-blind people and visible on black and white; for
// actors those of Okabe and Ito.
const kRamp = [[88, 60, 170], [50, 105, 180], [25, 150, 150], [105, 200, 90], [250, 230, 40]];
const kOwn = [[230, 159, 0], [86, 180, 233], [0, 158, 115], [240, 228, 66], [0, 114, 178], [213, 94, 0], [204, 121, 167]];
const kNobody = [130, 130, 130];
const kChosen = [255, 60, 200];  // visible on dark and on light
const css = rgb => `rgb(${rgb.map(Math.round)})`;
function ramp(v) {
  const at = Math.min(Math.max(v, 0), 1) * (kRamp.length - 1), i = Math.min(Math.floor(at), kRamp.length - 2);
  return kRamp[i].map((low, c) => low + (at - i) * (kRamp[i + 1][c] - low));
}
const ownColour = number => number === 0 ? kNobody : kOwn[(number - 1) % kOwn.length];

// Per colouring: a point's value, its position on the colour scale, and the labels of the scale's ends.
const kColourings = {
  height: {of: (p, from) => (p[2] - from[2] + 2.5) / 8, ends: ['-2.5 m', '5.5 m above the sensor']},
  intensity: {of: p => Math.sqrt(p[3]), ends: ['0', '1 (square root)']},
  range: {of: (p, from) => Math.log2(Math.max(Math.hypot(p[0] - from[0], p[1] - from[1], p[2] - from[2]), 1)) / 7, ends: ['1 m', '128 m (logarithm)']},
  ring: {of: (p, from, rings) => p[4] / rings, ends: ['top', 'bottom row']},
  time: {of: p => p[5], ends: ['start', 'end of the sweep']},
  actor: null};
// Returns [r, g, b] of each point, 0 to 255; `stride` values per point.
function coloursOf(points, stride, colouring, from) {
  const n = points.length / stride, colours = new Uint8Array(3 * n), how = kColourings[colouring];
  let rings = 1;
  for (let i = 0; i < n; ++i) rings = Math.max(rings, points[stride * i + 4]);
  for (let i = 0; i < n; ++i) {
    const p = points.subarray(stride * i, stride * (i + 1));
    colours.set(how ? ramp(how.of(p, from, rings)) : ownColour(p[6]), 3 * i);
  }
  return colours;
}
// Shows a colour scale beside a view with labels at its ends.
function showScale(element, stops, ends) {
  const bar = document.createElement('i');
  bar.style.background = `linear-gradient(90deg, ${stops.map(css)})`;
  element.replaceChildren(ends[0], bar, ends[1]);
  element.hidden = false;
}

const kVertex = `attribute vec3 place, tint; uniform mat4 clip_from_world; uniform float size; varying vec3 colour;
void main() { gl_Position = clip_from_world * vec4(place, 1.0); gl_PointSize = size; colour = tint; }`;
const kFragment = `precision mediump float; varying vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }`;

class PointView {
  constructor(canvas, over) {
    Object.assign(this, {canvas, over, orbit: new Orbit([0, 0, 0], 20, Math.PI, 0.4), points: new Float32Array(0), from: [0, 0, 0],
      size: 2, boxes: [], lines: [], marks: [], clear: [0, 0, 0, 0]});  // boxes: {name, shown, t, q, size}; lines: [points, rgb]
    const gl = this.gl = canvas.getContext('webgl', {antialias: true, preserveDrawingBuffer: true, premultipliedAlpha: true});
    if (!gl) return;
    const program = this.program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, kVertex], [gl.FRAGMENT_SHADER, kFragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    [this.placeBuffer, this.colourBuffer, this.lineBuffer] = [0, 1, 2].map(() => gl.createBuffer());
    this.at = Object.fromEntries(['place', 'tint'].map(name => [name, gl.getAttribLocation(program, name)]));
    gl.enableVertexAttribArray(this.at.place);
    gl.enable(gl.DEPTH_TEST);
  }
  get aspect() { return this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1); }
  // points: Float32Array of kPointValues each; `from`: the sensor's position.
  show(points, colouring, from) {
    Object.assign(this, {points, from});
    const gl = this.gl, n = points.length / kPointValues, places = new Float32Array(3 * n);
    if (!gl) return;
    for (let i = 0; i < n; ++i) for (let c = 0; c < 3; ++c) places[3 * i + c] = points[kPointValues * i + c];
    gl.bindBuffer(gl.ARRAY_BUFFER, this.placeBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, places, gl.STREAM_DRAW);
    this.colour(colouring);
  }
  colour(colouring) {
    const gl = this.gl;
    if (!gl) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.colourBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, coloursOf(this.points, kPointValues, colouring, this.from), gl.STREAM_DRAW);
  }
  draw() {
    const gl = this.gl, canvas = this.canvas, ratio = window.devicePixelRatio || 1;
    if (!gl) return;
    const w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
    if (w === 0 || h === 0) return;
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    gl.viewport(0, 0, w, h);
    gl.clearColor(...this.clear);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.program, 'clip_from_world'), false, this.orbit.matrix(w / h));
    gl.uniform1f(gl.getUniformLocation(this.program, 'size'), this.size * ratio);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.placeBuffer);
    gl.vertexAttribPointer(this.at.place, 3, gl.FLOAT, false, 0, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.colourBuffer);
    gl.enableVertexAttribArray(this.at.tint);
    gl.vertexAttribPointer(this.at.tint, 3, gl.UNSIGNED_BYTE, true, 0, 0);
    if (this.points.length > 0) gl.drawArrays(gl.POINTS, 0, this.points.length / kPointValues);
    gl.disableVertexAttribArray(this.at.tint);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lineBuffer);
    gl.vertexAttribPointer(this.at.place, 3, gl.FLOAT, false, 0, 0);
    const shown = this.boxes.filter(box => box.shown).map(box => [boxEdges(box), box.held ? kChosen : box.colour]);
    for (const [vertices, rgb] of [...this.lines, ...shown]) {  // pairs of ends
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices.flat()), gl.STREAM_DRAW);
      gl.vertexAttrib3fv(this.at.tint, rgb.map(v => v / 255));
      gl.drawArrays(gl.LINES, 0, vertices.length);
    }
    this.drawOver(w, h, ratio);
  }
  drawOver(w, h, ratio) {
    const over = this.over, pen = over.getContext('2d');
    [over.width, over.height] = [w, h];
    const at = point => { const p = this.orbit.project(point, w / h); return p && [p[0] * w, p[1] * h]; };
    const away = box => Math.hypot(...sub(box.t, this.orbit.eye)), taken = [];
    for (const box of [...this.boxes].sort((a, b) => away(a) - away(b))) {
      const p = box.shown && at(add(box.t, [0, 0, box.size[2] / 2]));
      if (p) tag(pen, box.name, p[0], p[1] - 4 * ratio, box.held ? kChosen : box.colour, ratio, taken);
    }
    const ends = this.marks.map(at);
    drawMeasure(pen, ends, this.marks, ratio);
  }
  // Returns viewpoint and direction through a canvas position.
  rayAt(event) {
    const r = this.canvas.getBoundingClientRect();
    const x = 2 * (event.clientX - r.left) / r.width - 1, y = 1 - 2 * (event.clientY - r.top) / r.height;
    return [this.orbit.eye, this.orbit.ray(x, y, r.width / r.height)];
  }
  boxAt(event) {
    const [eye, direction] = this.rayAt(event);
    let nearest = Infinity, found = null;
    for (const box of this.boxes) {
      const at = box.shown ? hitBox(box, eye, direction) : Infinity;
      if (at < nearest) [nearest, found] = [at, box];
    }
    return found;
  }
  // Returns the values of the nearest point within some pixels of the pointer; null: none.
  pointAt(event, within = 8) {
    const [eye, d] = this.rayAt(event), points = this.points;
    const per_pixel = 2 * Math.tan(kHalf) / this.canvas.clientHeight;
    let best = Infinity, found = -1;
    for (let i = 0; i < points.length; i += kPointValues) {
      const x = points[i] - eye[0], y = points[i + 1] - eye[1], z = points[i + 2] - eye[2], along = x * d[0] + y * d[1] + z * d[2];
      if (along <= 0.05) continue;
      const off = Math.sqrt(Math.max(x * x + y * y + z * z - along * along, 0)) / (along * per_pixel);
      if (off > within) continue;
      const cost = along * (1 + off);
      if (cost < best) [best, found] = [cost, i];
    }
    return found < 0 ? null : points.subarray(found, found + kPointValues);
  }
  // Returns the intersection with the horizontal plane at `height`; null without one.
  groundAt(event, height) {
    const [eye, direction] = this.rayAt(event);
    const s = (height - eye[2]) / direction[2];
    return s > 0 && s < 5000 ? add(eye, scale(direction, s)) : null;
  }
}

// Of overlapping names only the first is drawn.
function tag(pen, text, x, y, rgb, ratio, taken = []) {
  pen.font = `${12 * ratio}px system-ui, sans-serif`;
  const half = pen.measureText(text).width / 2;
  if (taken.some(other => Math.abs(other.x - x) < other.half + half + 8 * ratio && Math.abs(other.y - y) < 16 * ratio)) return;
  taken.push({x, y, half});
  pen.textAlign = 'center';
  pen.fillStyle = css(rgb);
  pen.fillRect(x - half - 4 * ratio, y - 12 * ratio, 2 * half + 8 * ratio, 16 * ratio);
  pen.fillStyle = dot(rgb, [0.3, 0.6, 0.1]) < 128 ? '#fff' : '#000';
  pen.fillText(text, x, y);
}
// Draws a measurement between two points: canvas positions [x, y], null if invisible, and positions in space.
function drawMeasure(pen, ends, points, ratio) {
  pen.strokeStyle = pen.fillStyle = '#ff2fd0';
  pen.lineWidth = 2 * ratio;
  for (const end of ends) if (end) pen.fillRect(end[0] - 3 * ratio, end[1] - 3 * ratio, 6 * ratio, 6 * ratio);
  if (ends.length !== 2 || !ends[0] || !ends[1]) return;
  pen.beginPath();
  pen.moveTo(...ends[0]);
  pen.lineTo(...ends[1]);
  pen.stroke();
  const length = Math.hypot(...sub(points[1], points[0]));
  tag(pen, `${length.toFixed(2)} m`, (ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2 - 6 * ratio, [255, 160, 235], ratio);
}

function boxEdges(box) {
  const corner = k => add(box.t, rotate(box.q, box.size.map((side, axis) => (k >> axis & 1 ? 0.5 : -0.5) * side)));
  const edges = [];
  for (let k = 0; k < 8; ++k) {
    for (let axis = 0; axis < 3; ++axis) if (!(k >> axis & 1)) edges.push(corner(k), corner(k | 1 << axis));
  }
  return edges;
}

function hitBox(box, eye, direction) {
  const back = inverse(box.q), o = rotate(back, sub(eye, box.t)), d = rotate(back, direction);
  let enter = 0, leave = Infinity;
  for (let axis = 0; axis < 3; ++axis) {
    const half = box.size[axis] / 2, a = (-half - o[axis]) / d[axis], b = (half - o[axis]) / d[axis];
    enter = Math.max(enter, Math.min(a, b));
    leave = Math.min(leave, Math.max(a, b));
  }
  return enter <= leave ? enter : Infinity;
}
