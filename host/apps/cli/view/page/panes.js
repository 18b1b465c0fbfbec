'use strict';
// The panes: their requests and the display of answers.

const points = new PointView($('points'), $('points-over'));
let selected = '';            // actor
let hovered = '';
let boxesInPicture = [];  // of the displayed picture
let seen = {points: new Float32Array(0), from: [0, 0, 0]};  // over the displayed picture
const marks = [];  // of a measurement: {point, picture: [x, y] or null}

function request(sensor) {
  const {quality, time, forward, left, up, yaw, pitch, edits} = state, of_scene = scene.kind === 'scene';
  const body = {sensor, quality, time_s: time, width: Math.round(state.width), forward_m: 0, left_m: 0, up_m: 0, yaw_rad: 0, pitch_rad: 0,
    removed: [], moved: {}};
  return of_scene ? {...body, forward_m: forward, left_m: left, up_m: up, yaw_rad: yaw, pitch_rad: pitch, removed: edits.removed,
    moved: edits.moved, turned_deg: edits.turned, retimed: edits.retimed} : {...body, quality: ''};
}
const pictureRequest = () => ({...request(state.camera), points: state.over ? state.lidar : '',
  ...(scene.kind === 'scene' && {layer: state.layer})});
function photoRequest() {
  const r = $('points').getBoundingClientRect(), width = Math.max(64, Math.min(Math.round(state.width), 4096));
  return {...request(state.camera), width, height: Math.max(64, Math.min(Math.round(width * r.height / r.width), 4096)),
    scene_from_camera: points.orbit.pose};
}

// --- pictures while something moves: smaller ones, so that they come at once -----------------------------

const kSharpAfter = 250, kAnswer = 50;  // ms
const kSizes = [1, 0.75, 0.5, 0.375, 0.25];
class Haste {
  constructor() { Object.assign(this, {until: 0, at: 2, hasty: false, timer: 0}); }
  // Called while the view changes; calls `sharpen` once it is at rest.
  move(sharpen) {
    this.until = performance.now() + kSharpAfter;
    clearTimeout(this.timer);
    this.timer = setTimeout(sharpen, kSharpAfter + 10);
  }
  // Returns the request's body, for a smaller picture while the view changes.
  body(body) {
    this.hasty = performance.now() < this.until;
    if (!this.hasty) return body;
    const small = side => Math.max(64, Math.round(side * kSizes[this.at]));
    return {...body, width: small(body.width), ...(body.height && {height: small(body.height)})};
  }
  // Adapts the size of the next picture to the time that the last one took.
  took(ms) {
    if (!this.hasty) return;
    if (ms > kAnswer) this.at = Math.min(this.at + 1, kSizes.length - 1);
    else if (1.6 * ms < kAnswer) this.at = Math.max(this.at - 1, 0);
  }
}
const haste = {camera: new Haste(), photo: new Haste()};

async function loadPicture(name, body) {
  const begin = performance.now();
  const [info, buffer, at] = await parts(await call('api/picture', body));
  const start = at + 4 * (kPointValues + 2) * (info.points || 0);
  const bitmap = await createImageBitmap(new Blob([new Uint8Array(buffer, start)], {type: 'image/jpeg'}));
  haste[name].took(performance.now() - begin);
  return {body, info, bitmap, over: new Float32Array(buffer, at, (start - at) / 4), ms: performance.now() - begin};
}
function drawBitmap(canvas, bitmap) {
  if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
  canvas.getContext('2d').drawImage(bitmap, 0, 0);
  canvas.dataset.frames = 1 + (+canvas.dataset.frames || 0);
}

const distance = m => m < 1 ? `${(100 * m).toFixed(0)} cm` : `${m} m`;
const rate = pane => pane.rate > 1 && pane.rate < 200 ? `, ${pane.rate.toFixed(1)} per s` : '';

const camera = new Pane('camera', $('picture'), () => [state.camera, state.quality, state.layer].join(), async () => {
  return state.camera ? loadPicture('camera', haste.camera.body(pictureRequest())) : null;
}, ({body, info, bitmap, over, ms}) => {
  drawBitmap($('picture'), bitmap);
  boxesInPicture = info.boxes;
  seen = {points: over, from: info.scene_from_camera?.t ?? [0, 0, 0]};
  $('picture').dataset.time = info.time_s;
  drawPictureOver();
  if (info.far_m > 0) showScale($('camera-scale'), scene.depth_colours.map(c => scale(c, 255)), [distance(info.near_m), distance(info.far_m)]);
  else if (body.layer === 'support') showScale($('camera-scale'), [[255, 107, 0], [64, 158, 255]], ['not known', 'as recorded']);
  else if (body.layer === 'opacity') showScale($('camera-scale'), [[0, 0, 0], [255, 255, 255]], ['0', '1']);
  else $('camera-scale').hidden = true;
  const more = {unseen: ` (hatched: no recorded camera faced it, ${(100 * info.unseen_share).toFixed(0)} %)`,
    support: ` (mean ${(100 * info.support).toFixed(0)} %)`}[body.layer] || '';
  const how = scene.kind === 'log' ? `recorded at ${info.time_s.toFixed(3)} s` : `${body.quality}, ${body.layer}${more}`;
  $('camera-time').textContent =
    `${body.sensor}, ${how}, ${bitmap.width} x ${bitmap.height}, ${info.render_ms.toFixed(0)} ms + ${info.encode_ms.toFixed(0)} ms JPEG, ${ms.toFixed(0)} ms in all${rate(camera)}`;
});

const photo = new Pane('photo', $('photo'), () => '', async () => state.photo ? loadPicture('photo', haste.photo.body(photoRequest())) : null,
  ({bitmap}) => drawBitmap($('photo'), bitmap));

const lidar = new Pane('lidar', $('points'), () => [state.lidar, state.quality].join(), async () => {
  if (!state.lidar) return null;
  const body = scene.kind === 'log' ? {...request(state.lidar), sweeps: Math.round(state.sweeps)} : request(state.lidar);
  const [info, buffer, at] = await parts(await call('api/sweep', body));
  return {body, info, data: new Float32Array(buffer, at)};
}, ({body, info, data}) => {
  const held = points.boxes.find(box => box.held);
  points.boxes = info.actors.map((actor, i) => ({...actor, number: i + 1, held: held && held.name === actor.name}));
  points.show(data, state.colour, info.scene_from_sensor.t);
  if (state.follow && points.follows) points.orbit.target = add(points.orbit.target, sub(info.scene_from_sensor.t, points.follows));
  points.follows = info.scene_from_sensor.t;
  $('points').dataset.time = info.time_s;
  const what = info.every > 1 ? `returns (1 in ${info.every})` : 'returns';
  $('lidar-time').textContent = scene.kind === 'log' ?
    `${body.sensor}, ${data.length / kPointValues} ${what} of ${info.sweeps} ${info.sweeps > 1 ? 'sweeps' : 'sweep'}, recorded at ${info.time_s.toFixed(3)} s` :
    `${body.sensor}, ${body.quality}, ${data.length / kPointValues} returns of ${info.rays} rays, ${info.render_ms.toFixed(0)} ms${rate(lidar)}`;
  drawSpace();
  $('points').dataset.frames = 1 + (+$('points').dataset.frames || 0);
  if (state.photo) panes.ask(['photo']);
});
const panes = new Panes([camera, lidar, photo]);

// --- what is drawn over them -----------------------------------------------------------------------------

// Returns the rectangle of the fitted picture in a canvas, in CSS pixels.
function fitted(canvas) {
  const w = canvas.clientWidth, h = canvas.clientHeight, s = Math.min(w / canvas.width, h / canvas.height);
  return {x: (w - s * canvas.width) / 2, y: (h - s * canvas.height) / 2, w: s * canvas.width, h: s * canvas.height};
}
// Returns the pointer's position on the picture as shares of its sides; null outside.
function pictureAt(event) {
  const r = $('picture').getBoundingClientRect(), fit = fitted($('picture'));
  const at = [(event.clientX - r.left - fit.x) / fit.w, (event.clientY - r.top - fit.y) / fit.h];
  return at.every(v => v >= 0 && v <= 1) ? at : null;
}
const colourOfBox = name => [selected, hovered].includes(name) ? kChosen : ownColour(1 + scene.actors.findIndex(a => a.name === name));

function drawPictureOver() {
  const over = $('picture-over'), pen = over.getContext('2d'), ratio = window.devicePixelRatio || 1, fit = fitted($('picture'));
  [over.width, over.height] = [over.clientWidth * ratio, over.clientHeight * ratio];
  const at = (x, y) => [ratio * (fit.x + x * fit.w), ratio * (fit.y + y * fit.h)];
  const stride = kPointValues + 2, side = state.size * ratio, colours = coloursOf(seen.points, stride, state.colour, seen.from);
  for (let i = 0; i * stride < seen.points.length; ++i) {
    const [x, y] = at(seen.points[stride * i + kPointValues], seen.points[stride * i + kPointValues + 1]);
    pen.fillStyle = css([...colours.subarray(3 * i, 3 * i + 3)]);
    pen.fillRect(x - side / 2, y - side / 2, side, side);
  }
  if (state.boxes) {
    const taken = [];
    for (const box of boxesInPicture) {
      const rgb = colourOfBox(box.name);
      pen.strokeStyle = css(rgb);
      pen.lineWidth = 1.5 * ratio;
      let top = [0, Infinity];
      for (const line of box.lines) {
        pen.beginPath();
        for (let i = 0; i < line.length; i += 2) {
          const p = at(line[i], line[i + 1]);
          pen.lineTo(...p);
          if (p[1] < top[1]) top = p;
        }
        pen.stroke();
      }
      tag(pen, box.name, top[0], Math.max(top[1] - 4 * ratio, 14 * ratio), rgb, ratio, taken);
    }
  }
  drawMeasure(pen, marks.map(mark => mark.picture && at(...mark.picture)), marks.map(mark => mark.point), ratio);
}

// Draws the cloud with the trajectory, the cameras and their directions at the current time.
function drawSpace() {
  const rig = rigAt(state.time), moved = {q: rig.q, t: place(rig, [state.forward, state.left, state.up])};
  const path = scene.poses.flatMap((pose, i) => i > 0 ? [scene.poses[i - 1].t, pose.t] : []);
  points.lines = [[path, [150, 150, 150]]];
  for (const name of scene.cameras) {
    const {rig_from_camera, outline} = scene.mountings[name], eye = place(moved, rig_from_camera.t), q = times(moved.q, rig_from_camera.q);
    const ends = outline.map(ray => add(eye, rotate(q, scale(ray, 1.5)))), chosen = name === state.camera;
    const edges = ends.flatMap((end, i) => [end, ends[(i + 1) % ends.length], ...(i % 8 === 0 ? [eye, end] : [])]);
    points.lines.push([edges, chosen ? kChosen : [140, 170, 220]]);
  }
  points.size = state.size;
  points.marks = marks.map(mark => mark.point);
  for (const box of points.boxes) Object.assign(box, {shown: box.is_there && state.boxes, colour: colourOfBox(box.name)});
  const dark = getComputedStyle($('points').parentElement).backgroundColor.match(/\d+/g).map(Number);
  if (!(dark[0] < 128)) for (const line of points.lines) line[1] = line[1].map(v => v / 2);
  $('photo').hidden = !state.photo;
  points.draw();
  const how = kColourings[state.colour];
  if (how) showScale($('lidar-scale'), kRamp, how.ends);
  else showScale($('lidar-scale'), [kNobody, ...kOwn], ['no actor', 'actors']);
}
function drawAll() {
  drawPictureOver();
  drawSpace();
}
