'use strict';
// The actors: a row of controls for each, of what the page changes about it.

// `q` behind a turn to the left about z by `degrees`: of a vector in an actor's turned axes, in those before.
function turnedLeft(q, degrees) {
  const h = degrees * Math.PI / 360, [c, s] = [Math.cos(h), Math.sin(h)];
  return [c * q[0] - s * q[3], c * q[1] - s * q[2], c * q[2] + s * q[1], c * q[3] + s * q[0]];
}

// A number field for entry k of map.get(name), or of the value itself where it is one.
function field(label, unit, map, name, k, usual, step) {
  const values = () => map.has(name) ? map.get(name) : usual;
  const input = Object.assign(document.createElement('input'), {
    type: 'number', step, value: +(Array.isArray(usual) ? values()[k] : values()).toFixed(3)});
  input.dataset.edit = `${name} ${label}`;
  input.onchange = () => {
    if (Array.isArray(usual)) map.set(name, values().map((value, i) => i === k ? +input.value : value));
    else map.set(name, +input.value);
    refresh();
  };
  const out = document.createElement('label');
  out.append(label + ' ', input, unit && ' ' + unit);
  return out;
}

function actorRow(actor) {
  const row = Object.assign(document.createElement('div'), {className: 'actor'}), name = actor.name;
  const shown = Object.assign(document.createElement('input'), {type: 'checkbox', checked: !state.removed.has(name)});
  shown.dataset.actor = name;
  shown.onchange = () => { state.removed[shown.checked ? 'delete' : 'add'](name); refresh(); };
  const title = document.createElement('label');
  title.append(shown, ' ', name, ' ', Object.assign(document.createElement('span'), {className: 'soft', textContent: actor.kind}));
  const twice = Object.assign(document.createElement('button'), {textContent: 'duplicate'});
  twice.dataset.duplicate = name;
  twice.onclick = () => duplicate(name).catch(error => say(error.message));
  row.append(
    title, ...['forward', 'left', 'up'].map((axis, k) => field(axis, 'm', state.moved, name, k, [0, 0, 0], 0.25)),
    field('turned', 'deg', state.turned, name, 0, 0, 5), field('rate', '', state.retimed, name, 0, [1, 0], 0.1),
    field('later', 's', state.retimed, name, 1, [1, 0], 0.1), twice);
  return row;
}

function listActors() {
  $('actors').replaceChildren(...scene.actors.map(actorRow));
  $('actors-view').querySelector('h2').hidden = scene.actors.length === 0;
}

// A second one of the same, beside it.
async function duplicate(name) {
  const {actor} = await (await call('api/duplicate', {actor: name})).json();
  const [forward, left, up] = state.moved.get(name) || [0, 0, 0];
  state.moved.set(actor, [forward, left - 3, up]);
  for (const map of [state.turned, state.retimed]) if (map.has(name)) map.set(actor, map.get(name));
  await reload();
}

// Splats dropped anywhere on the page: an actor ahead of the rig.
async function addSplats(file) {
  const query = new URLSearchParams({file: file.name, time_s: state.time});
  const {actor, moved_m} = await (await call(`api/add?${query}`, file)).json();
  state.moved.set(actor, moved_m);
  await reload();
}
addEventListener('dragover', e => e.preventDefault());
addEventListener('drop', async e => {
  e.preventDefault();
  for (const file of e.dataTransfer.files) {
    say(`adding ${file.name} ...`);
    await addSplats(file).then(() => say(''), error => say(error.message));
  }
});
