'use strict';
// Requests, and updates of the panes.

const $ = id => document.getElementById(id);
const token = new URLSearchParams(location.search).get('token') || '';
const pause = ms => new Promise(done => setTimeout(done, ms));
// `from`: the source whose next success clears the message.
function say(text, from = '') {
  $('message').textContent = text;
  $('message').dataset.from = from;
}

class Gone extends Error {}

// `body`: bytes, else an object sent as JSON. Throws Gone without an answer.
async function call(path, body) {
  const bytes = body instanceof Blob ? body : body && JSON.stringify(body);
  const reply = await fetch(path, {method: body ? 'POST' : 'GET', headers: {'X-Simuli-Token': token}, body: bytes})
    .catch(() => { throw new Gone('the viewer does not answer: trying again ...'); });
  if (reply.ok) return reply;
  const text = await reply.text();
  throw new Error(text || reply.statusText);
}

// Parses a reply of two parts: the length of a JSON text, the text, and bytes from the next multiple of four.
async function parts(reply) {
  const buffer = await reply.arrayBuffer(), length = new DataView(buffer).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, 4, length));
  return [JSON.parse(text), buffer, 4 + Math.ceil(length / 4) * 4];
}

// A pane: `load()` requests data and returns it for `paint()`. `what()` identifies the requested data; the pane
// is faint while it shows other data.
class Pane {
  constructor(name, canvas, what, load, paint) {
    Object.assign(this, {name, canvas, what, load, paint, wanted: false, shown: null, rate: 0, last: 0});
  }
  mark() { this.canvas.classList.toggle('stale', this.shown !== null && this.shown !== this.what()); }
  note(text) { const line = $(this.name + '-note'); if (line) line.textContent = text; }
}

// All panes show the same moment: data requested together are shown together. Requests made meanwhile are
// merged and use the newest state.
class Panes {
  constructor(panes) { Object.assign(this, {panes, running: null, turn: 0}); }
  ask(names) {
    for (const pane of this.panes) {
      if (!names.includes(pane.name)) continue;
      pane.wanted = true;
      pane.mark();
    }
    this.running ??= this.run().finally(() => { this.running = null; });
    return this.running;
  }
  async run() {
    await null;  // merges requests of one task
    for (let due; (due = this.panes.filter(pane => pane.wanted)).length > 0; ++this.turn) {
      const waiting = setTimeout(() => this.wait(this.turn, due), 400);
      const results = await Promise.allSettled(due.map(pane => {
        pane.wanted = false;
        const what = pane.what();
        return pane.load().then(loaded => [what, loaded]);
      }));
      clearTimeout(waiting);
      let gone = false;
      results.forEach((result, i) => {
        const pane = due[i];
        pane.note('');
        try {
          if (result.status === 'rejected') throw result.reason;
          const [what, loaded] = result.value;
          if (loaded !== null) pane.paint(loaded);
          pane.shown = what;
          if ($('message').dataset.from === pane.name) say('');
          const now = performance.now();
          pane.rate = 0.7 * pane.rate + 300 / Math.max(now - pane.last, 1);
          pane.last = now;
        } catch (error) {
          gone ||= error instanceof Gone;
          say(error.message, pane.name);
        }
        pane.mark();
      });
      if (gone) await reconnect();
    }
  }
  // Shows the reason of a long wait.
  async wait(turn, due) {
    while (turn === this.turn && this.running) {
      const activity = await call('api/status').then(reply => reply.json()).then(s => s.activity, () => '');
      if (turn !== this.turn) return;
      for (const pane of due) pane.note(`${activity || 'rendering'} ...`);
      await pause(300);
    }
  }
}

// Retries until the server answers, then requests everything again.
async function reconnect() {
  for (;;) {
    await pause(1000);
    try { await reload(); break; } catch (error) { if (!(error instanceof Gone)) say(error.message); }
  }
  say('');
}
