'use strict';
// A row of controls per actor with its edits. Selecting a row selects its box.

// Returns q in the axes before a left rotation about z by `degrees`.
function turnedLeft(q, degrees) {
  const h = degrees * Math.PI / 360;
  return times([Math.cos(h), 0, 0, Math.sin(h)], q);
}

function changeEdits(how) {
  how(state.edits);
  changed();
  refresh();
}
function setRemoved(name, removed) {
  changeEdits(edits => { edits.removed = [...edits.removed.filter(other => other !== name), ...(removed ? [name] : [])]; });
}

// Returns a number field for entry k of state.edits[kind][name], or for the value itself if it is a number.
function field(label, unit, kind, name, k, usualValue, step) {
  const value = () => state.edits[kind][name] ?? usualValue;
  const input = Object.assign(document.createElement('input'), {
    type: 'number', step, value: +(Array.isArray(usualValue) ? value()[k] : value()).toFixed(3)});
  input.dataset.edit = `${name} ${label}`;
  input.onchange = () => changeEdits(edits => {
    edits[kind][name] = Array.isArray(usualValue) ? value().map((v, i) => i === k ? +input.value : v) : +input.value;
  });
  const out = document.createElement('label');
  out.append(label + ' ', input, unit && ' ' + unit);
  return out;
}

function actorRow(actor) {
  const row = Object.assign(document.createElement('div'), {className: 'actor'}), name = actor.name;
  row.dataset.row = name;
  row.onclick = event => { if (!['INPUT', 'BUTTON'].includes(event.target.tagName)) choose(name); };
  row.onpointerenter = () => { hovered = name; drawAll(); };
  row.onpointerleave = () => { hovered = ''; drawAll(); };
  const title = document.createElement('div');
  const kind = Object.assign(document.createElement('span'), {className: 'soft', textContent: actor.kind});
  title.append(name, ' ', kind);
  row.append(title);
  if (scene.kind === 'log') return row;
  const shown = Object.assign(document.createElement('input'), {type: 'checkbox', checked: !state.edits.removed.includes(name)});
  shown.dataset.actor = name;
  shown.ariaLabel = `${name} is there`;
  shown.onchange = () => setRemoved(name, !shown.checked);
  title.prepend(shown, ' ');
  const twice = Object.assign(document.createElement('button'), {textContent: 'duplicate'});
  twice.dataset.duplicate = name;
  twice.onclick = () => duplicate(name).catch(error => say(error.message));
  row.append(...['forward', 'left', 'up'].map((axis, k) => field(axis, 'm', 'moved', name, k, [0, 0, 0], 0.25)),
    field('turned', 'deg', 'turned', name, 0, 0, 5), field('rate', '', 'retimed', name, 0, [1, 0], 0.1),
    field('later', 's', 'retimed', name, 1, [1, 0], 0.1), twice);
  return row;
}

function listActors() {
  $('actors').replaceChildren(...scene.actors.map(actorRow));
  $('actors-view').querySelector('h2').textContent = scene.actors.length > 0 ? 'Actors' : 'no actors';
  choose(selected, false);
}

// Selects the named actor; '': none.
function choose(name, show = true) {
  selected = name;
  for (const row of $('actors').children) row.classList.toggle('selected', row.dataset.row === name);
  if (name && show) {
    $('actors-view').hidden = false;
    $('actors').querySelector('.selected')?.scrollIntoView({block: 'nearest'});
  }
  drawAll();
}

// Adds a copy of an actor beside it.
async function duplicate(name) {
  const {actor} = await (await call('api/duplicate', {actor: name})).json();
  settle();
  addedNow(actor);
  const {moved, turned, retimed} = state.edits, [forward, left, up] = moved[name] || [0, 0, 0];
  moved[actor] = [forward, left - 3, up];
  for (const map of [turned, retimed]) if (name in map) map[actor] = map[name];
  settle();
  await reload();
}

// Adds splats dropped on the page as an actor ahead of the rig. Returns a message.
async function addSplats(file) {
  const query = new URLSearchParams({file: file.name, time_s: state.time});
  const {actor, moved_m, notes} = await (await call(`api/add?${query}`, file)).json();
  settle();
  addedNow(actor);
  state.edits.moved[actor] = moved_m;
  settle();
  await reload();
  return notes.map((note) => `${file.name}: ${note}`).join('; ');
}
addEventListener('dragover', e => e.preventDefault());
addEventListener('drop', async e => {
  e.preventDefault();
  for (const file of e.dataTransfer.files) {
    say(`adding ${file.name} ...`);
    await addSplats(file).then(say, error => say(error.message));
  }
});
