'use strict';
// The page's state, its controls, and the requests that keep both views up to date.

let scene = null;             // what /api/scene says
let orbit = null;             // of the free camera
const points = new PointView($('points'));
const state = {time: 0, forward: 0, left: 0, up: 0, yaw: 0, pitch: 0, removed: new Set(), moved: new Map(), turned: new Map(),
  retimed: new Map()};

function request(sensor) {
  return {
    sensor, quality: $('quality').value, time_s: state.time, width: Math.round(+$('width').value),
    forward_m: state.forward, left_m: state.left, up_m: state.up, yaw_rad: state.yaw, pitch_rad: state.pitch,
    layer: 'colour', lossless: false, removed: [...state.removed], moved: Object.fromEntries(state.moved),
    turned_deg: Object.fromEntries(state.turned), retimed: Object.fromEntries(state.retimed)};
}

function pictureRequest() {
  const body = request($('camera').value);
  body.layer = $('layer').value;
  if ($('free').checked) body.scene_from_camera = orbit.pose;
  return body;
}

const shownAs = (id, ...more) => () => [$(id).value, $('quality').value, ...more.map(other => $(other).value)].join(', ');
const distance = m => m < 1 ? `${(100 * m).toFixed(0)} cm` : `${m} m`;

const camera = new Live('camera', $('picture'), shownAs('camera', 'layer'), async live => {
  const body = pictureRequest();
  if (!body.sensor) return;
  const [info, buffer, at] = await parts(await call('api/picture', body));
  const bitmap = await createImageBitmap(new Blob([new Uint8Array(buffer, at)], {type: 'image/jpeg'}));
  const canvas = $('picture');
  if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
    [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
    canvas.style.aspectRatio = `${bitmap.width} / ${bitmap.height}`;
  }
  canvas.getContext('2d').drawImage(bitmap, 0, 0);
  const scale = info.far_m > 0 ? ` ${distance(info.near_m)} (pale) to ${distance(info.far_m)} (dark)` : '';
  const unseen = body.layer === 'unseen' ? ` (hatched: no recorded camera faced it, ${(100 * info.unseen_share).toFixed(0)} %)` : '';
  const support = body.layer === 'support' ? ` (red: not known, green: as recorded; mean ${(100 * info.support).toFixed(0)} %)` : '';
  $('camera-time').textContent =
    `${body.sensor}, ${body.quality}, ${body.layer}${scale}${unseen}${support}, ${bitmap.width} x ${bitmap.height}, ${info.render_ms.toFixed(0)} ms + ${info.encode_ms.toFixed(0)} ms JPEG` +
    (live.rate ? `, ${live.rate.toFixed(1)} per s` : '');
  canvas.dataset.frames = 1 + (+canvas.dataset.frames || 0);
});

const lidar = new Live('lidar', $('points'), shownAs('lidar'), async live => {
  const body = request($('lidar').value);
  if (!body.sensor) return;
  const [info, buffer, at] = await parts(await call('api/sweep', body));
  const data = new Float32Array(buffer, at);
  points.show(data, $('colour').value, info.scene_from_sensor.t);
  const held = points.boxes.find(box => box.held);
  points.boxes = info.actors.map(actor => ({...actor, shown: actor.is_there, held: held && held.name === actor.name}));
  if ($('follow').checked) points.orbit.target = info.scene_from_sensor.t;
  points.draw();
  $('lidar-time').textContent = `${body.sensor}, ${body.quality}, ${data.length / kPointValues} returns of ${info.rays} rays, ${info.render_ms.toFixed(0)} ms` +
    (live.rate ? `, ${live.rate.toFixed(1)} per s` : '');
  $('points').dataset.frames = 1 + (+$('points').dataset.frames || 0);
});

function refresh() {
  $('time').value = state.time;
  $('time-text').textContent = `${state.time.toFixed(2)} s`;
  camera.ask();
  lidar.ask();
}

function setTime(time) {
  state.time = Math.min(Math.max(time, scene.time_start_s), scene.time_end_s);
  refresh();
}

function offer(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// The picture as it is chosen now, without loss.
async function save() {
  const body = {...pictureRequest(), lossless: true};
  const [, buffer, at] = await parts(await call('api/picture', body));
  offer(new Blob([new Uint8Array(buffer, at)], {type: 'image/png'}), `${body.sensor}_${body.layer}_${body.time_s.toFixed(3)}s.png`);
}

// All that the picture shows until the button is pressed again, as it is shown. Every frame of a drive: simuli render -o X.mp4.
let recorder = null;
function clip() {
  if (recorder) { recorder.stop(); return; }
  if (!window.MediaRecorder) { say('this browser records no canvas'); return; }
  const chunks = [], name = `${$('camera').value}_${state.time.toFixed(3)}s.webm`;
  recorder = new MediaRecorder($('picture').captureStream());
  recorder.ondataavailable = event => chunks.push(event.data);
  recorder.onstop = () => {
    const blob = new Blob(chunks, {type: recorder.mimeType});
    offer(blob, name);
    recorder = null;
    $('clip').textContent = 'clip';
    $('clip').dataset.bytes = blob.size;
  };
  recorder.start();
  $('clip').textContent = 'stop';
}

// The command line that makes what is chosen now: shown, and copied where the browser lets us.
async function tellCommand(body) {
  const {command} = await (await call('api/command', body)).json();
  $('command').hidden = false;
  $('command').value = command;
  if (navigator.clipboard) await navigator.clipboard.writeText(command).catch(() => $('command').select());
}

let playing = 0;
function play() {
  if (playing) { clearInterval(playing); playing = 0; $('play').innerHTML = '&#9654;'; return; }
  $('play').innerHTML = '&#10074;&#10074;';
  let last = performance.now();
  playing = setInterval(() => {
    const now = performance.now(), next = state.time + (now - last) / 1000;
    last = now;
    setTime(next > scene.time_end_s ? scene.time_start_s : next);
  }, 50);
}

// Dragging with what was grabbed at the start.
function dragging(canvas, start) {
  canvas.addEventListener('contextmenu', e => e.preventDefault());
  canvas.addEventListener('pointerdown', e => {
    canvas.setPointerCapture(e.pointerId);
    canvas.focus();
    let [x, y] = [e.clientX, e.clientY];
    const {move, end} = start(e);
    const onMove = m => { move(m.clientX - x, m.clientY - y, m); [x, y] = [m.clientX, m.clientY]; };
    canvas.addEventListener('pointermove', onMove);
    canvas.addEventListener('pointerup', () => { canvas.removeEventListener('pointermove', onMove); if (end) end(); }, {once: true});
  });
}

dragging($('picture'), () => ({move: (dx, dy, e) => {
  if ($('free').checked) {
    if (e.buttons & 2) orbit.pan(-dx * orbit.distance / 800, -dy * orbit.distance / 800);
    else orbit.turn(dx / 250, dy / 250);
  } else {
    state.yaw += dx / 500;
    state.pitch = Math.min(Math.max(state.pitch + dy / 500, -1.5), 1.5);
  }
  camera.ask();
}}));

dragging($('points'), e => {
  const box = e.button === 0 ? points.boxAt(e) : null;
  const grabbed = box && points.groundAt(e, box.t[2]);
  if (!grabbed) {
    return {move: (dx, dy, m) => {
      if (m.buttons & 2 || m.shiftKey) {
        $('follow').checked = false;
        points.orbit.pan(-dx * points.orbit.distance / 700, -dy * points.orbit.distance / 700);
      } else points.orbit.turn(dx / 250, dy / 250);
      points.draw();
    }};
  }
  const before = state.moved.get(box.name) || [0, 0, 0];
  // Moved along its own axes as they were before it was turned.
  const inverse = turnedLeft([box.q[0], -box.q[1], -box.q[2], -box.q[3]], state.turned.get(box.name) || 0);
  box.held = true;
  return {
    move: (dx, dy, m) => {
      const at = points.groundAt(m, grabbed[2]);
      if (!at) return;
      state.moved.set(box.name, add(before, rotate(inverse, sub(at, grabbed))));
      refresh();
    },
    end: () => { for (const b of points.boxes) b.held = false; listActors(); points.draw(); }};
});
$('points').addEventListener('dblclick', e => {
  const box = points.boxAt(e);
  if (box) { state.removed.add(box.name); listActors(); refresh(); }
});
$('points').addEventListener('wheel', e => { e.preventDefault(); points.orbit.zoom(Math.exp(e.deltaY / 800)); points.draw(); }, {passive: false});
$('picture').addEventListener('wheel', e => {
  if (!$('free').checked) return;
  e.preventDefault();
  orbit.zoom(Math.exp(e.deltaY / 800));
  camera.ask();
}, {passive: false});

document.addEventListener('keydown', e => {
  if (e.target.tagName === 'INPUT' || e.target.tagName === 'SELECT' || !scene) return;
  const step = e.shiftKey ? 1 : 0.25;
  const along = (forward, left) => {  // in the direction looked at
    state.forward += step * (forward * Math.cos(state.yaw) - left * Math.sin(state.yaw));
    state.left += step * (forward * Math.sin(state.yaw) + left * Math.cos(state.yaw));
  };
  const keys = {w: () => along(1, 0), s: () => along(-1, 0), a: () => along(0, 1), d: () => along(0, -1),
    q: () => { state.up -= step; }, e: () => { state.up += step; },
    arrowright: () => setTime(state.time + 0.1), arrowleft: () => setTime(state.time - 0.1), ' ': play};
  const act = keys[e.key.toLowerCase()];
  if (!act) return;
  e.preventDefault();
  act();
  $('left').value = state.left.toFixed(2);
  $('up').value = state.up.toFixed(2);
  refresh();
});

async function reload() {
  scene = await (await call('api/scene')).json();
  points.path = scene.path;
  listActors();
  refresh();
}

// While a training runs: how far it is, and its newest scene.
async function watch() {
  let version = -1;
  for (;;) {
    const s = await (await call('api/status')).json();
    $('training').hidden = !s.training;
    if (s.training) {
      $('bar').value = s.iteration / s.iterations;
      const number = (v, digits, unit) => v === null ? '' : `  ${v.toFixed(digits)} ${unit}`;
      $('state').textContent = `training ${s.iteration} / ${s.iterations}${number(s.psnr_db, 2, 'dB')}` +
        number(s.distance_m === null ? null : 100 * s.distance_m, 1, 'cm') +
        `  ${((s.camera_particles + s.lidar_particles) / 1e3).toFixed(0)} k particles`;
    }
    if (s.version !== version && version !== -1) await reload();  // another scene: more actors, perhaps
    version = s.version;
    await pause(s.training ? 1000 : 5000);
  }
}

function fill(select, groups, chosen) {
  for (const [label, names] of groups) {
    const group = Object.assign(document.createElement('optgroup'), {label});
    group.append(...names.map(name => new Option(name, name, name === chosen, name === chosen)));
    if (names.length > 0) select.append(group);
  }
}

async function start() {
  scene = await (await call('api/scene')).json();
  $('name').textContent = scene.name || 'simuli';
  $('device').textContent = scene.device;
  fill($('camera'), [['of the scene', scene.cameras], ['built in', scene.builtin_cameras]], scene.cameras[0]);
  fill($('lidar'), [['of the scene', scene.lidars], ['built in', scene.builtin_lidars]], scene.lidars[0]);
  fill($('quality'), [['', scene.qualities]], scene.quality);
  $('time').min = scene.time_start_s;
  $('time').max = scene.time_end_s;
  points.path = scene.path;
  orbit = new Orbit(scene.path[0], 15, Math.PI, 0.35);
  points.orbit.azimuth = orbit.azimuth = scene.heading_rad + Math.PI;
  state.time = scene.time_start_s;
  listActors();
  $('time').oninput = () => setTime(+$('time').value);
  $('play').onclick = play;
  for (const id of ['left', 'up']) $(id).oninput = () => { state[id] = +$(id).value; refresh(); };
  for (const id of ['camera', 'layer', 'width', 'free']) $(id).onchange = () => camera.ask();
  for (const id of ['lidar', 'colour']) $(id).onchange = () => lidar.ask();
  $('follow').onchange = () => lidar.ask();
  $('quality').onchange = refresh;
  $('clip').onclick = clip;
  $('save').onclick = () => save().catch(error => say(error.message));
  const tell = request => tellCommand(request()).catch(error => {
    say(error.message);
    $('message').dataset.from = 'camera';  // until the next picture
  });
  $('camera-command').onclick = () => tell(pictureRequest);
  $('lidar-command').onclick = () => tell(() => request($('lidar').value));
  $('home').onclick = () => {
    Object.assign(state, {forward: 0, left: 0, up: 0, yaw: 0, pitch: 0});
    $('left').value = $('up').value = 0;
    $('free').checked = false;
    refresh();
  };
  new ResizeObserver(() => points.draw()).observe($('points'));
  refresh();
  watch().catch(error => say(error.message));
}
start().catch(error => say(error.message));
