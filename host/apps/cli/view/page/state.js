'use strict';
// State of the page: stored in its address; edits can be undone.

const kNoEdits = {removed: [], moved: {}, turned: {}, retimed: {}};
const kUsual = {time: null, camera: '', layer: 'colour', lidar: '', colour: 'height', quality: '', width: 960, forward: 0, left: 0,
  up: 0, yaw: 0, pitch: 0, size: 2, sweeps: 1, over: true, boxes: true, follow: true, photo: false, speed: '1', loop: true,
  every: false, theme: 'auto', only: '', split: 0.5, orbit: null, edits: kNoEdits};
let scene = null;  // reply of /api/scene
let usual = {...kUsual};  // initial state of the scene
const state = structuredClone(kUsual);

// --- the address -----------------------------------------------------------------------------------------

function addressOfState() {
  const said = new URLSearchParams();
  for (const [key, value] of Object.entries(state)) {
    const text = JSON.stringify(value);
    if (text !== JSON.stringify(usual[key])) said.set(key, typeof value === 'string' ? value : text);
  }
  return '#' + said;
}

// Reads the state from the address; ignores values of a wrong type.
function readAddress() {
  Object.assign(state, structuredClone(usual));
  for (const [key, text] of new URLSearchParams(location.hash.slice(1))) {
    if (!(key in kUsual)) continue;
    try {
      const value = typeof kUsual[key] === 'string' ? text : JSON.parse(text);
      const like = usual[key];
      if (typeof value === typeof like && (value === null) === (like === null)) state[key] = value;
    } catch { say(`address: ${key} found ${text}, allowed what this page wrote`); }
  }
  state.edits = {...structuredClone(kNoEdits), ...state.edits};
}

// --- undo ------------------------------------------------------------------------------------------------

const kUndone = ['edits', 'forward', 'left', 'up', 'yaw', 'pitch'];
const snapshot = () => JSON.stringify(kUndone.map(key => state[key]));
const past = {before: [], after: [], now: ''};

function settle() {
  if (snapshot() !== past.now) {
    past.before.push(past.now);
    past.after = [];
    past.now = snapshot();
  }
  history.replaceState(null, '', addressOfState());
  showPast();
}
function showPast() {
  $('undo').disabled = past.before.length === 0;
  $('redo').disabled = past.after.length === 0;
}
let settling = 0;
let held = 0;  // pressed pointers
for (const [type, by] of [['pointerdown', 1], ['pointerup', -1], ['pointercancel', -1]])
  addEventListener(type, () => { held = Math.max(0, held + by); }, true);
// Called after each change: changes of one task or one drag are one undo step.
function changed() {
  clearTimeout(settling);
  settling = setTimeout(() => (held > 0 ? changed() : settle()), 300);
}
function step(from, to) {
  clearTimeout(settling);
  settle();
  if (from().length === 0) return;
  to().push(past.now);
  past.now = from().pop();
  JSON.parse(past.now).forEach((value, i) => { state[kUndone[i]] = value; });
  settle();
  listActors();
  refresh();
}
const undo = () => step(() => past.before, () => past.after);
const redo = () => step(() => past.after, () => past.before);
// Removes an actor that was added later from the undo steps.
function addedNow(name) {
  const without = text => {
    const values = JSON.parse(text);
    values[0].removed.push(name);
    return JSON.stringify(values);
  };
  past.before = past.before.map(without);
  past.now = without(past.now);
}

// --- time ------------------------------------------------------------------------------------------------

// Returns the camera that looks ahead, if there is one.
function frontCamera() {
  const ahead = name => rotate(scene.mountings[name].rig_from_camera.q, [0, 0, 1])[0];
  return [...scene.cameras].sort((a, b) => ahead(b) - ahead(a))[0];
}
// Returns the start times of the displayed frames: the camera's; for a built-in camera those of the camera that
// it replaces.
function frameTimes() {
  const times = scene.frames[state.camera] || scene.frames[frontCamera()] || scene.frames[scene.lidars[0]];
  if (times && times.length > 0) return times.map(span => span[0]);
  const count = Math.max(1, Math.floor(10 * (scene.time_end_s - scene.time_start_s)));
  return Array.from({length: count}, (_, i) => scene.time_start_s + i / 10);
}
// Returns the frame at that time.
function frameAt(time) {
  const times = frameTimes();
  let at = 0;
  for (let i = 0; i < times.length; ++i) if (times[i] <= time + 1e-6) at = i;
  return at;
}
// Returns the first time at which every sensor has a frame.
const firstTime = () => Math.max(...[frontCamera(), scene.lidars[0]].map(name => scene.frames[name]?.[0]?.[0] ?? scene.time_start_s));

// Returns scene_from_rig at that time.
function rigAt(time) {
  const poses = scene.poses;
  let i = 0;
  while (i + 2 < poses.length && poses[i + 1].time_s <= time) ++i;
  const a = poses[i], b = poses[Math.min(i + 1, poses.length - 1)];
  const share = b.time_s > a.time_s ? Math.min(Math.max((time - a.time_s) / (b.time_s - a.time_s), 0), 1) : 0;
  return {t: add(scale(a.t, 1 - share), scale(b.t, share)), q: blend(a.q, b.q, share)};
}
