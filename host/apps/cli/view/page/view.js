'use strict';
// Controls: fields, mouse, touch, keys, and playback.

function refresh() {
  $('time').value = state.time;
  const count = frameTimes().length, digits = String(count - 1).length;
  $('time-text').textContent = `frame ${String(frameAt(state.time)).padStart(digits)} of ${count - 1}, ` +
    `${state.time.toFixed(3)} of ${scene.time_end_s.toFixed(3)} s`;
  showFields();
  $('command-box').close();
  return panes.ask(['camera', 'lidar']);
}

function setTime(time) {
  state.time = Math.min(Math.max(time, scene.time_start_s), scene.time_end_s);
  changed();
  return refresh();
}
function toFrame(number) {
  const all = frameTimes();
  return setTime(all[Math.min(Math.max(number, 0), all.length - 1)]);
}

// --- fields: an element with data-state="key" is state[key]; data-asks says which panes depend on it -----

const fields = () => document.querySelectorAll('[data-state]');
function showFields() {
  for (const e of fields()) {
    if (e === document.activeElement && e.type === 'number') continue;
    const value = state[e.dataset.state];
    if (e.type === 'checkbox') e.checked = value; else e.value = e.type === 'number' ? +(+value).toFixed(3) : value;
  }
  document.documentElement.dataset.theme = state.theme;
  $('main').className = state.only && `only-${state.only}`;
  $('main').style.setProperty('--first', state.only ? '' : `${state.split}fr`);
  $('main').style.setProperty('--second', state.only ? '' : `${1 - state.split}fr`);
}
function bindFields() {
  for (const e of fields()) {
    e.onchange = () => {
      if (e.type === 'number' && !e.checkValidity()) { say(`${e.dataset.state}: found ${e.value}, allowed ${e.min} to ${e.max}`, e.dataset.state); return; }
      state[e.dataset.state] = e.type === 'checkbox' ? e.checked : e.type === 'number' ? +e.value : e.value;
      say('');
      $('command-box').close();
      showFields();
      if (e.type !== 'number') e.blur();  // returns the keys to the page
      changed();
      const asks = (e.dataset.asks || '').split(' ');
      if (asks.includes('draw') || e.dataset.state === 'lidar') points.colour(state.colour);
      if (e.dataset.state === 'camera') refresh();
      panes.ask(asks);
      drawAll();
    };
  }
}

function fill(select, groups) {
  for (const [label, names] of groups) {
    const group = Object.assign(document.createElement('optgroup'), {label});
    group.append(...names.map(name => new Option(name, name)));
    if (names.length > 0) select.append(group);
  }
}

// --- files -----------------------------------------------------------------------------------------------

function offer(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// Saves the current picture losslessly.
async function save() {
  const body = {...pictureRequest(), points: '', lossless: true};
  const [, buffer, at] = await parts(await call('api/picture', body));
  offer(new Blob([new Uint8Array(buffer, at)], {type: 'image/png'}), `${body.sensor}_${body.layer || 'recorded'}_${body.time_s.toFixed(3)}s.png`);
}

// Records the displayed picture until the button is pressed again. For every frame of a drive use simuli render
// -o X.mp4.
let recorder = null;
function clip() {
  if (recorder) { recorder.stop(); return; }
  if (!window.MediaRecorder) { say('this browser records no canvas'); return; }
  const chunks = [], name = `${state.camera}_${state.time.toFixed(3)}s.webm`;
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

// Shows the equivalent command line, and copies it if the browser allows; or shows why there is none.
async function tellCommand(body) {
  const told = await call('api/command', body).then(reply => reply.json()).then(reply => reply.command, error => error.message);
  $('command').value = told;
  if (!$('command-box').open) $('command-box').showModal();
  if (navigator.clipboard) await navigator.clipboard.writeText(told).catch(() => $('command').select());
}

// --- time goes by: the next moment is asked for when the last one is shown -------------------------------

let playing = null;
async function play() {
  const me = playing = playing ? null : {};
  $('play').innerHTML = playing ? '&#10074;&#10074;' : '&#9654;';
  for (let last = performance.now(); me && me === playing;) {
    const now = performance.now(), speed = +state.speed, all = frameTimes(), i = frameAt(state.time);
    if (state.every) {
      const next = i + 1 < all.length ? i + 1 : 0;
      if (next === 0 && !state.loop) { play(); break; }
      await Promise.all([setTime(all[next]), pause(next > 0 ? 1000 * (all[next] - all[i]) / speed : 100)]);
      continue;
    }
    const next = state.time + (now - last) / 1000 * speed;
    last = now;
    if (next > scene.time_end_s && !state.loop) { setTime(scene.time_end_s); play(); break; }
    haste.camera.move(() => { if (!playing) panes.ask(['camera']); });
    // a slow device's step may be longer than the drive
    const first = firstTime(), around = first + (next - first) % (scene.time_end_s - first);
    await Promise.all([setTime(next > scene.time_end_s ? around : next), pause(20)]);
  }
}

// --- mouse and touch -------------------------------------------------------------------------------------

// One pointer drags the result of start(event): move(dx, dy, event), end(); two pan and pinch: both(dx, dy,
// factor).
function pointing(canvas, start, both) {
  const down = new Map();
  let held = null;
  canvas.addEventListener('contextmenu', e => e.preventDefault());
  canvas.addEventListener('pointerdown', e => {
    canvas.setPointerCapture(e.pointerId);
    canvas.focus();
    down.set(e.pointerId, [e.clientX, e.clientY]);
    if (down.size > 1) { held?.end?.(); held = null; } else held = start(e);
  });
  canvas.addEventListener('pointermove', e => {
    const before = down.get(e.pointerId);
    if (!before) return;
    const now = [e.clientX, e.clientY], [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    if (down.size === 2) {
      const other = [...down].find(([id]) => id !== e.pointerId)[1], apart = p => Math.hypot(p[0] - other[0], p[1] - other[1]);
      both(dx / 2, dy / 2, Math.max(apart(before), 1) / Math.max(apart(now), 1));
    } else if (down.size === 1) held?.move(dx, dy, e);
    down.set(e.pointerId, now);
  });
  const up = e => {
    if (!down.delete(e.pointerId) || down.size > 0) return;
    held?.end?.();
    held = null;
  };
  canvas.addEventListener('pointerup', up);
  canvas.addEventListener('pointercancel', up);
}

function placed() {  // called after the rig has moved
  haste.camera.move(() => panes.ask(['camera']));
  changed();
  showFields();
  $('command-box').close();
  drawSpace();
}
function drive(forward, left, up) {  // along the viewing direction
  if (scene.kind === 'log') return;
  state.forward += forward * Math.cos(state.yaw) - left * Math.sin(state.yaw);
  state.left += forward * Math.sin(state.yaw) + left * Math.cos(state.yaw);
  state.up += up;
  placed();
  panes.ask(['camera', 'lidar']);
}
function orbited() {
  haste.photo.move(() => panes.ask(['photo']));
  const {target, distance, azimuth, elevation} = points.orbit;
  state.orbit = {target, distance, azimuth, elevation};
  changed();
  drawSpace();
  if (state.photo) panes.ask(['photo']);
}
const panOrbit = (dx, dy) => {
  const per_pixel = 2 * Math.tan(kHalf) * points.orbit.distance / $('points').clientHeight;
  points.orbit.pan(-dx * per_pixel, -dy * per_pixel);
  orbited();
};

function bindPointers() {
  pointing($('picture'), e => {
    if (measuring) { mark(e, 'picture'); return null; }
    return {move: (dx, dy) => {
      if (scene.kind === 'log') return;
      state.yaw += dx * 0.003;
      state.pitch = Math.min(Math.max(state.pitch - dy * 0.003, -1.5), 1.5);
      placed();
      panes.ask(['camera']);
    }};
  }, (dx, dy, factor) => drive(Math.log(1 / factor) * 4, dx / 100, dy / 100));
  $('picture').addEventListener('wheel', e => { e.preventDefault(); drive(-e.deltaY / 200, 0, 0); }, {passive: false});

  pointing($('points'), e => {
    if (measuring) { mark(e, 'space'); return null; }
    const box = e.button === 0 && !e.shiftKey ? points.boxAt(e) : null;
    const grabbed = box && scene.kind === 'scene' && points.groundAt(e, box.t[2]);
    let moved = false;
    if (!grabbed) {
      return {move: (dx, dy, m) => {
        moved = true;
        if (m.buttons & 2 || m.shiftKey) panOrbit(dx, dy);
        else { points.orbit.turn(dx / 250, dy / 250); orbited(); }
      }, end: () => { if (!moved) choose(box ? box.name : ''); }};
    }
    const before = state.edits.moved[box.name] || [0, 0, 0];
    // Along the actor's axes before its rotation.
    const back = turnedLeft(inverse(box.q), state.edits.turned[box.name] || 0);
    choose(box.name, false);  // the list would move the dragged box
    box.held = true;
    return {
      move: (dx, dy, m) => {
        const at = points.groundAt(m, grabbed[2]);
        if (!at) return;
        const [forward, left] = rotate(back, sub(at, grabbed));  // on the actor's ground plane
        changeEdits(edits => { edits.moved[box.name] = add(before, [forward, left, 0]).map(v => +v.toFixed(3)); });
      },
      end: () => { for (const b of points.boxes) b.held = false; listActors(); choose(box.name); }};
  }, (dx, dy, factor) => { points.orbit.zoom(factor); panOrbit(dx, dy); });
  $('points').addEventListener('wheel', e => { e.preventDefault(); points.orbit.zoom(Math.exp(e.deltaY / 800)); orbited(); }, {passive: false});
  $('points').addEventListener('dblclick', e => pick(e, 'space').then(focusOn));

  let [resting, under] = [0, null];
  for (const [canvas, pane] of [[$('picture'), 'picture'], [$('points'), 'space']]) {
    canvas.addEventListener('pointermove', e => {
      under = lastPointer = {clientX: e.clientX, clientY: e.clientY, pane};
      clearTimeout(resting);
      if (e.buttons === 0) resting = setTimeout(() => { if (under && !playing) read(under).catch(() => {}); }, 120);
    });
    canvas.addEventListener('pointerleave', () => { under = lastPointer = null; });
  }
  const splitter = $('splitter');
  pointing(splitter, () => ({move: (dx, dy, m) => {
    const r = $('main').getBoundingClientRect(), down = innerWidth <= 800;
    const share = down ? (m.clientY - r.top) / r.height : (m.clientX - r.left) / (r.width - $('actors-view').offsetWidth);
    state.split = +Math.min(Math.max(share, 0.1), 0.9).toFixed(3);
    showFields();
    changed();
  }}), () => {});
}

// --- what is under the pointer ---------------------------------------------------------------------------

let lastPointer = null, measuring = false;
const metres = v => v === null || v === undefined ? 'nothing' : `${v.toFixed(2)} m`;

// Returns the object under the pointer: {point (null: nothing), text, picture}.
async function pick(e, pane) {
  if (pane === 'space') {
    const p = points.pointAt(e);
    if (!p) return {point: null, text: ''};
    const range = Math.hypot(...sub([...p.subarray(0, 3)], points.from));
    const whose = p[6] > 0 ? `, ${scene.actors[p[6] - 1]?.name}` : '';
    return {point: [...p.subarray(0, 3)], text: `${range.toFixed(2)} m, intensity ${p[3].toFixed(3)}, ring ${p[4]}, ${(100 * p[5]).toFixed(0)} % of the sweep${whose}`};
  }
  const at = pictureAt(e);
  if (!at) return {point: null, text: ''};
  const found = await (await call('api/probe', {...pictureRequest(), pixel: at})).json();
  const said = [`pixel ${Math.floor(at[0] * $('picture').width)}, ${Math.floor(at[1] * $('picture').height)}`, metres(found.distance_m)];
  for (const [key, label] of [['depth_m', 'z'], ['opacity', 'opacity'], ['support', 'support'], ['intensity', 'intensity'], ['ring', 'ring']]) {
    if (found[key] !== null && found[key] !== undefined) said.push(`${label} ${found[key].toFixed(key === 'ring' ? 0 : 2)}`);
  }
  if (found.actor) said.push(found.actor);
  return {point: found.point, text: said.join(', '), picture: at};
}
async function read(e) {
  const {text} = await pick(e, e.pane);
  if (marks.length === 2) return;  // a complete measurement stays
  $(e.pane === 'picture' ? 'camera-reading' : 'lidar-reading').textContent = text;
}

function setMeasuring(on) {
  measuring = on;
  marks.length = 0;
  document.body.classList.toggle('measuring', on);
  $('measure').ariaPressed = on;
  drawAll();
}
async function mark(e, pane) {
  const found = await pick(e, pane).catch(error => { say(error.message); return {point: null}; });
  if (!found.point) return;
  if (marks.length === 2) marks.length = 0;
  marks.push({point: found.point, picture: found.picture || null});
  if (marks.length === 2) {
    const d = sub(marks[1].point, marks[0].point);
    $('lidar-reading').textContent = $('camera-reading').textContent =
      `${Math.hypot(...d).toFixed(3)} m (${d.map(v => v.toFixed(2)).join(', ')} along x, y, z)`;
  }
  drawAll();
}

// Sets the centre of rotation to the point under the pointer, the selected box, or the rig.
function focusOn({point}) {
  if (!point) return;
  points.orbit.target = point;
  orbited();
}
async function focus() {
  const found = lastPointer ? await pick(lastPointer, lastPointer.pane) : {point: null};
  const box = points.boxes.find(b => b.name === selected && b.shown);
  focusOn(found.point ? found : {point: box ? box.t : rigAt(state.time).t});
  if (!found.point && box) { points.orbit.distance = 3 * Math.max(...box.size); orbited(); }
}

// --- keys: what the help shows is what there is ----------------------------------------------------------

const toggled = key => () => document.querySelector(`[data-state=${key}]`).click();
function maximise(pane) {
  state.only = state.only === pane ? '' : pane;
  changed();
  showFields();
  drawAll();
}
const inSpace = () => document.activeElement === $('points');
const walk = (right, up, forward) => () => {
  if (!inSpace()) { drive(0.25 * forward, -0.25 * right, 0.25 * up); return; }
  const {azimuth, distance, target} = points.orbit, s = distance / 20, [c, n] = [-Math.cos(azimuth), -Math.sin(azimuth)];
  points.orbit.target = add(target, scale([c * forward + n * right, n * forward - c * right, up], s));
  orbited();
};
const kKeys = [
  [' ', 'play, stop', () => play()],
  ['ArrowRight', 'a frame on', () => toFrame(frameAt(state.time) + 1)], ['ArrowLeft', 'a frame back', () => toFrame(frameAt(state.time) - 1)],
  ['Shift+ArrowRight', '1 s on', () => setTime(state.time + 1)], ['Shift+ArrowLeft', '1 s back', () => setTime(state.time - 1)],
  ['Home', 'first frame', () => toFrame(0)], ['End', 'last frame', () => toFrame(Infinity)],
  ['l', 'loop', toggled('loop')], ['e', 'every frame', toggled('every')],
  ['w', 'drive on; in the 3D view: go on', walk(0, 0, 1)], ['s', 'back', walk(0, 0, -1)], ['a', 'to the left', walk(-1, 0, 0)],
  ['d', 'to the right', walk(1, 0, 0)], ['PageUp', 'up', walk(0, 1, 0)], ['PageDown', 'down', walk(0, -1, 0)],
  ['r', 'onto the recorded path, looking ahead', () => goHome()],
  ['f', 'turn the 3D view about what is under the pointer, the chosen actor, or the rig', () => focus().catch(error => say(error.message))],
  ['m', 'measure between two clicks', () => setMeasuring(!measuring)], ['b', 'boxes', toggled('boxes')],
  ['p', 'the 3D view with the rendered picture', toggled('photo')],
  ['Delete', 'take the chosen actor away', () => { if (selected && scene.kind === 'scene') { setRemoved(selected, true); listActors(); } }],
  ['Ctrl+z', 'undo', () => undo()], ['Ctrl+Shift+Z', 'redo', () => redo()], ['Ctrl+y', 'redo', () => redo()],
  ['x', 'one pane alone, or both', () => maximise(state.only || (inSpace() ? 'space' : 'camera'))],
  ['?', 'this help', () => $('help').showModal()],
  ['Escape', 'measure nothing, choose nothing', () => { setMeasuring(false); choose(''); }]];
const nameOfKey = e => (e.ctrlKey || e.metaKey ? 'Ctrl+' : '') + (e.shiftKey && e.key !== '?' ? 'Shift+' : '') + e.key;
document.addEventListener('keydown', e => {
  const {tagName, type} = e.target;
  const typing = tagName === 'TEXTAREA' || tagName === 'SELECT' || (tagName === 'INPUT' && type === 'number') || (tagName === 'BUTTON' && e.key === ' ');
  if (typing || !scene || document.querySelector('dialog[open]')) return;
  const name = nameOfKey(e), found = kKeys.find(([key]) => key === name || (key.length === 1 && key === name.toLowerCase()));
  if (!found) return;
  e.preventDefault();
  found[2]();
});

// Returns the keys to the page after a click.
document.addEventListener('click', e => { if (e.detail > 0) e.target.closest('button')?.blur(); });

function goHome() {
  Object.assign(state, {forward: 0, left: 0, up: 0, yaw: 0, pitch: 0});
  changed();
  refresh();
}

// --- the server ------------------------------------------------------------------------------------------

async function reload() {
  scene = await (await call('api/scene')).json();
  listActors();
  refresh();  // not awaited: the panes may wait for this function
}

// During a training: shows its progress and its newest scene.
async function watch() {
  for (let version = -1; ;) {
    const s = await call('api/status').then(reply => reply.json(), () => null);
    $('training').hidden = !s?.training;
    if (s?.training) {
      $('bar').value = s.iteration / s.iterations;
      const number = (v, digits, unit) => v === null ? '' : `  ${v.toFixed(digits)} ${unit}`;
      $('state').textContent = `training ${s.iteration} / ${s.iterations}${number(s.psnr_db, 2, 'dB')}` +
        number(s.distance_m === null ? null : 100 * s.distance_m, 1, 'cm') +
        `  ${((s.camera_particles + s.lidar_particles) / 1e3).toFixed(0)} k particles`;
    }
    if (!s) { say('the viewer does not answer: trying again ...', 'watch'); version = -2; }
    else {
      if ($('message').dataset.from === 'watch') say('');
      // another scene, or another viewer
      if (s.version !== version && version !== -1) await reload().catch(() => {});
      version = s.version;
    }
    await pause(!s || s.training ? 1000 : 3000);
  }
}

function restore() {
  readAddress();
  const {orbit} = state;
  if (orbit && [...(orbit.target || []), orbit.distance, orbit.azimuth, orbit.elevation].every(Number.isFinite)) Object.assign(points.orbit, structuredClone(orbit));
  past.now = snapshot();
}

async function start() {
  scene = await (await call('api/scene')).json();
  $('name').textContent = scene.name || 'simuli';
  $('device').textContent = scene.device || 'log';
  for (const e of document.querySelectorAll(scene.kind === 'log' ? '.of-scene' : '.of-log')) e.hidden = true;
  fill($('camera'), [['of the ' + scene.kind, scene.cameras], ['built in', scene.builtin_cameras || []]]);
  fill($('lidar'), [['of the ' + scene.kind, scene.lidars], ['built in', scene.builtin_lidars || []]]);
  fill($('quality'), [['', scene.qualities || []]]);
  if (!scene.has_support) for (const option of $('layer').options) if (option.value === 'support') option.disabled = true;
  const time = firstTime(), rig = rigAt(time), [x, y] = rotate(rig.q, [1, 0, 0]);
  const around = {target: place(rig, [6, 0, 0]), distance: 22, azimuth: Math.atan2(y, x) + Math.PI, elevation: 0.35};
  usual = {...usual, time, camera: frontCamera() || '', lidar: scene.lidars[0] || '', quality: scene.quality || '', orbit: around, over: scene.kind === 'log'};
  $('time').min = scene.time_start_s;
  $('time').max = scene.time_end_s;
  Object.assign(points.orbit, around);
  points.follows = null;
  restore();
  $('keys').replaceChildren(...kKeys.map(([key, what]) => {
    const row = document.createElement('tr');
    row.append(...[key === ' ' ? 'Space' : key.replace(/(^|\+)\w/g, c => c.toUpperCase()), what].map(text =>
      Object.assign(document.createElement('td'), {textContent: text})));
    return row;
  }));
  bindFields();
  bindPointers();
  listActors();
  showPast();
  const on = (id, act) => { $(id).onclick = act; };
  $('time').oninput = () => { haste.camera.move(() => panes.ask(['camera'])); setTime(+$('time').value); };
  on('play', () => play());
  on('back', () => toFrame(frameAt(state.time) - 1));
  on('on', () => toFrame(frameAt(state.time) + 1));
  on('clip', clip);
  on('save', () => save().catch(error => say(error.message)));
  on('camera-command', () => tellCommand(pictureRequest()));
  on('lidar-command', () => tellCommand(state.photo ? photoRequest() : request(state.lidar)));
  on('home', goHome);
  on('undo', undo);
  on('redo', redo);
  on('reset', () => { changeEdits(edits => Object.assign(edits, structuredClone(kNoEdits), {removed: [...scene.added]})); listActors(); });
  on('measure', () => setMeasuring(!measuring));
  on('show-help', () => $('help').showModal());
  on('show-actors', () => { $('actors-view').hidden = !$('actors-view').hidden; });
  for (const button of document.querySelectorAll('.maximise')) button.onclick = () => maximise(button.closest('.pane').id.split('-')[0]);
  addEventListener('hashchange', () => { restore(); listActors(); refresh(); });
  matchMedia('(prefers-color-scheme: dark)').onchange = drawAll;
  const resized = new ResizeObserver(() => {
    drawAll();
    if (state.photo) panes.ask(['photo']);  // with the pane's aspect
  });
  for (const stage of document.querySelectorAll('.stage')) resized.observe(stage);
  refresh();
  watch().catch(error => say(error.message));
}
start().catch(error => say(error.message));
