'use strict';
// The sweep as points, the actors as boxes, with WebGL.

const kPointValues = 7;  // x y z intensity ring time actor

const kPointShader = `attribute vec3 place; attribute float value; uniform mat4 clip_from_world; uniform float size;
varying vec3 colour;
vec3 ramp(float v) {
  v = clamp(v, 0.0, 1.0);
  return mix(mix(vec3(.12,.35,.75), vec3(.2,.8,.6), smoothstep(0.0,.4,v)), vec3(1.0,.85,.3), smoothstep(.4,1.0,v));
}
void main() { gl_Position = clip_from_world * vec4(place, 1.0); gl_PointSize = size; colour = ramp(value); }`;
const kLineShader = `attribute vec3 place; uniform mat4 clip_from_world; uniform vec3 tint; varying vec3 colour;
void main() { gl_Position = clip_from_world * vec4(place, 1.0); colour = tint; }`;
const kFragment = `precision mediump float; varying vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }`;

class PointView {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext('webgl', {antialias: true, preserveDrawingBuffer: true});
    this.orbit = new Orbit([0, 0, 0], 40, Math.PI, 0.5);
    this.count = 0;
    this.boxes = [];   // {name, shown, t, q, size, tint}
    this.path = [];
    if (!this.gl) return;
    const gl = this.gl;
    this.programs = [kPointShader, kLineShader].map(source => this.program(source));
    this.places = gl.createBuffer();
    this.values = gl.createBuffer();
    this.lines = gl.createBuffer();
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.03, 0.04, 0.05, 1);
  }
  program(vertex) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, kFragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return program;
  }
  // points: Float32Array of kPointValues each; `from` the sensor's place.
  show(points, colour, from) {
    if (!this.gl) return;
    const n = points.length / kPointValues, places = new Float32Array(3 * n), values = new Float32Array(n);
    let rings = 1;
    for (let i = 0; i < n; ++i) rings = Math.max(rings, points[kPointValues * i + 4]);
    const valueOf = {
      height: p => (p[2] - from[2] + 2.5) / 8,
      intensity: p => Math.sqrt(p[3]),
      range: p => 1 - Math.log(1 + Math.hypot(p[0] - from[0], p[1] - from[1], p[2] - from[2])) / 5,
      ring: p => 1 - p[4] / rings,
      time: p => p[5],
      actor: p => p[6] === 0 ? 0.05 : 0.55 + 0.45 * (p[6] * 0.618 % 1)}[colour];
    for (let i = 0; i < n; ++i) {
      const p = points.subarray(kPointValues * i, kPointValues * (i + 1));
      places.set(p.subarray(0, 3), 3 * i);
      values[i] = valueOf(p);
    }
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.places);
    gl.bufferData(gl.ARRAY_BUFFER, places, gl.STREAM_DRAW);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.values);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STREAM_DRAW);
    this.count = n;
  }
  draw() {
    const gl = this.gl, canvas = this.canvas;
    if (!gl) return;
    const ratio = window.devicePixelRatio || 1;
    const w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    gl.viewport(0, 0, w, h);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const matrix = this.orbit.matrix(w / h);
    const use = (program, buffer) => {
      gl.useProgram(program);
      gl.uniformMatrix4fv(gl.getUniformLocation(program, 'clip_from_world'), false, matrix);
      this.attribute(program, 'place', buffer, 3);
    };
    if (this.count > 0) {
      use(this.programs[0], this.places);
      gl.uniform1f(gl.getUniformLocation(this.programs[0], 'size'), 1.5 * ratio);
      this.attribute(this.programs[0], 'value', this.values, 1);
      gl.drawArrays(gl.POINTS, 0, this.count);
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lines);
    const line = (vertices, tint, mode) => {
      if (vertices.length === 0) return;
      gl.bindBuffer(gl.ARRAY_BUFFER, this.lines);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices.flat()), gl.STREAM_DRAW);
      use(this.programs[1], this.lines);
      gl.uniform3fv(gl.getUniformLocation(this.programs[1], 'tint'), tint);
      gl.drawArrays(mode, 0, vertices.length);
    };
    line(this.path, [0.5, 0.5, 0.5], gl.LINE_STRIP);
    for (const box of this.boxes) {
      if (box.shown) line(boxEdges(box), box.held ? [1, 1, 1] : [1, 0.45, 0.2], gl.LINES);
    }
  }
  attribute(program, name, buffer, size) {
    const gl = this.gl, at = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
  }
  // Eye and direction through a place of the canvas.
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
  // Where the ray meets the horizontal plane at `height`; null when it does not.
  groundAt(event, height) {
    const [eye, direction] = this.rayAt(event);
    const s = (height - eye[2]) / direction[2];
    return s > 0 && s < 5000 ? add(eye, scale(direction, s)) : null;
  }
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
  const inverse = [box.q[0], -box.q[1], -box.q[2], -box.q[3]];
  const o = rotate(inverse, sub(eye, box.t)), d = rotate(inverse, direction);
  let enter = 0, leave = Infinity;
  for (let axis = 0; axis < 3; ++axis) {
    const half = box.size[axis] / 2, a = (-half - o[axis]) / d[axis], b = (half - o[axis]) / d[axis];
    enter = Math.max(enter, Math.min(a, b));
    leave = Math.min(leave, Math.max(a, b));
  }
  return enter <= leave ? enter : Infinity;
}
