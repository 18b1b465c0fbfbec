'use strict';
// Rotations and projections. Quaternions are [w, x, y, z]; frames as everywhere in simuli: a_from_b.

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = a => scale(a, 1 / Math.hypot(...a));

function rotate(q, v) {
  const u = [q[1], q[2], q[3]];
  const t = scale(cross(u, v), 2);
  return add(add(v, scale(t, q[0])), cross(u, t));
}

const inverse = q => [q[0], -q[1], -q[2], -q[3]];
const place = (a_from_b, v) => add(a_from_b.t, rotate(a_from_b.q, v));
const times = (p, q) => [p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
  p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]];
// Interpolates between two similar rotations.
function blend(a, b, share) {
  const sign = a.reduce((sum, v, i) => sum + v * b[i], 0) < 0 ? -1 : 1;
  const q = a.map((v, i) => (1 - share) * v + share * sign * b[i]), n = Math.hypot(...q);
  return q.map(v => v / n);
}

// Returns the quaternion of a rotation's columns.
function quaternion(x, y, z) {
  const trace = x[0] + y[1] + z[2];
  if (trace > 0) {
    const s = 2 * Math.sqrt(trace + 1);
    return [s / 4, (y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s];
  }
  if (x[0] > y[1] && x[0] > z[2]) {
    const s = 2 * Math.sqrt(1 + x[0] - y[1] - z[2]);
    return [(y[2] - z[1]) / s, s / 4, (y[0] + x[1]) / s, (z[0] + x[2]) / s];
  }
  if (y[1] > z[2]) {
    const s = 2 * Math.sqrt(1 + y[1] - x[0] - z[2]);
    return [(z[0] - x[2]) / s, (y[0] + x[1]) / s, s / 4, (z[1] + y[2]) / s];
  }
  const s = 2 * Math.sqrt(1 + z[2] - x[0] - y[1]);
  return [(x[1] - y[0]) / s, (z[0] + x[2]) / s, (z[1] + y[2]) / s, s / 4];
}

const kHalf = 0.45;  // half vertical field of view of an orbit, rad: ViewRequest::kFreeHalf_rad

// A viewpoint at `distance` from `target`, z up; azimuth and elevation in rad.
class Orbit {
  constructor(target, distance, azimuth, elevation) { Object.assign(this, {target, distance, azimuth, elevation}); }
  get eye() {
    const c = Math.cos(this.elevation);
    const away = [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation)];
    return add(this.target, scale(away, this.distance));
  }
  // Returns the directions right, down, forward in the world.
  get axes() {
    const forward = unit(sub(this.target, this.eye));
    const right = unit(cross(forward, [0, 0, 1]));
    return [right, cross(forward, right), forward];
  }
  turn(dx, dy) {
    this.azimuth -= dx;
    this.elevation = Math.min(Math.max(this.elevation + dy, -1.5), 1.55);
  }
  zoom(factor) { this.distance = Math.min(Math.max(this.distance * factor, 0.5), 2000); }
  pan(right, down) {
    const [x, y] = this.axes;
    this.target = add(this.target, add(scale(x, right), scale(y, down)));
  }
  // Returns scene_from_camera of a camera at the viewpoint (x right, y down, z forward).
  get pose() { return {t: this.eye, q: quaternion(...this.axes)}; }
  // Returns clip_from_world, column-major.
  matrix(aspect) {
    const [x, y, z] = this.axes, e = this.eye;
    const f = 1 / Math.tan(kHalf), near = Math.max(0.05, this.distance / 500), far = this.distance * 50 + 2000;
    const a = (far + near) / (far - near), b = -2 * far * near / (far - near);
    const sx = f / aspect, sy = -f;
    return new Float32Array([
      sx * x[0], sy * y[0], a * z[0], z[0], sx * x[1], sy * y[1], a * z[1], z[1],
      sx * x[2], sy * y[2], a * z[2], z[2], -sx * dot(x, e), -sy * dot(y, e), b - a * dot(z, e), -dot(z, e)]);
  }
  // Projects a point to a canvas of that aspect, as shares of its sides; null behind the viewpoint.
  project(point, aspect) {
    const [right, down, forward] = this.axes, v = sub(point, this.eye), z = dot(v, forward), t = 2 * Math.tan(kHalf);
    return z > 0.05 ? [0.5 + dot(v, right) / (z * t * aspect), 0.5 + dot(v, down) / (z * t), z] : null;
  }
  // Returns the world direction of a canvas point, (x, y) in [-1, 1], y up.
  ray(x, y, aspect) {
    const [right, down, forward] = this.axes, t = Math.tan(kHalf);
    return unit(add(forward, add(scale(right, x * t * aspect), scale(down, -y * t))));
  }
}
