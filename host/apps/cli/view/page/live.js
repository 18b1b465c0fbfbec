'use strict';
// Requests, and what keeps a canvas up to date with them.

const $ = id => document.getElementById(id);
const token = new URLSearchParams(location.search).get('token') || '';
const say = text => { $('message').textContent = text; };
const pause = ms => new Promise(done => setTimeout(done, ms));

// `body`: bytes as they are, else JSON.
async function call(path, body) {
  const bytes = body instanceof Blob ? body : body && JSON.stringify(body);
  const reply = await fetch(path, {method: body ? 'POST' : 'GET', headers: {'X-Simuli-Token': token}, body: bytes});
  if (reply.ok) return reply;
  const text = await reply.text();
  throw new Error(text || reply.statusText);
}

// A reply of two parts: the length of a JSON text, the text, and bytes from the next multiple of four.
async function parts(reply) {
  const buffer = await reply.arrayBuffer(), length = new DataView(buffer).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, 4, length));
  return [JSON.parse(text), buffer, 4 + Math.ceil(length / 4) * 4];
}

// Keeps one request in flight; what is asked for meanwhile is done once, with the newest state. `what()` names
// what the canvas is to show: while it shows something else it is faint.
class Live {
  constructor(name, canvas, what, work) {
    Object.assign(this, {name, canvas, what, work, wanted: false, running: false, shown: null, turn: 0, frames: 0,
      since: performance.now(), rate: 0});
  }
  ask() {
    this.wanted = true;
    this.canvas.classList.toggle('stale', this.shown !== null && this.shown !== this.what());
    if (!this.running) this.run();
  }
  async run() {
    this.running = true;
    while (this.wanted) {
      this.wanted = false;
      const what = this.what(), waiting = setTimeout(() => this.wait(this.turn), 300);
      try {
        await this.work(this);
        this.shown = what;
        if ($('message').dataset.from === this.name) say('');
      } catch (error) { say(error.message); $('message').dataset.from = this.name; }
      clearTimeout(waiting);
      this.turn += 1;
      $(this.name + '-note').textContent = '';
      this.canvas.classList.toggle('stale', this.shown !== null && this.shown !== this.what());
      this.frames += 1;
      const now = performance.now();
      if (now - this.since > 1000) {
        this.rate = 1000 * this.frames / (now - this.since);
        [this.frames, this.since] = [0, now];
      }
    }
    this.running = false;
  }
  // Says what takes so long.
  async wait(turn) {
    while (turn === this.turn) {
      const activity = await call('api/status').then(reply => reply.json()).then(s => s.activity, () => '');
      if (turn !== this.turn) return;
      $(this.name + '-note').textContent = `${activity || 'rendering'} ...`;
      await pause(300);
    }
  }
}
