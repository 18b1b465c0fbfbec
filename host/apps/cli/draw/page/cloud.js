'use strict';
// Interactive point clouds, rasterised on a 2D canvas: no library, no graphics card.

const kBehind = {yaw: Math.PI, pitch: 0.42, away: 42, at: [12, 0, 0]};
const kAbove = {yaw: Math.PI, pitch: 1.5, away: 110, at: [0, 0, 0]};
const kRings_m = [10, 20, 40, 80];

function bytesOf(base64) {
  const text = atob(base64.trim()), out = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) out[i] = text.charCodeAt(i);
  return out;
}
// "#rrggbb" as a little-endian number of ImageData.
const colourOf = hex => 0xff000000 | parseInt(hex.slice(5, 7) + hex.slice(3, 5) + hex.slice(1, 3), 16);

class Cloud {
  constructor(figure) {
    this.canvas = figure.querySelector('canvas');
    this.context = this.canvas.getContext('2d');
    this.layers = [...figure.querySelectorAll('script[data-name]')].map(Cloud.read);
    this.boxes = JSON.parse(this.canvas.dataset.boxes);
    this.ramp = this.makeRamp(this.canvas.dataset.ramp.split(','));
    this.isLight = false;
    this.by = 'layer';
    const heights = Array.from(this.layers[0].z).sort((a, b) => a - b);
    this.ground = heights.length ? heights[Math.floor(heights.length / 50)] : 0;
    this.makeTools(figure.querySelector('.tools'));
    this.listen();
    this.look(kBehind);
  }
  // Decodes stored values: all x, all y, all z in 16 bits, all intensities in 8, to metres.
  static read(script) {
    const bytes = bytesOf(script.textContent), n = +script.dataset.count, step = +script.dataset.step;
    const steps = new Int16Array(bytes.buffer, 0, 3 * n);
    const metres = Float32Array.from(steps, value => value * step);
    return {name: script.dataset.name, colour: script.dataset.colour, isShown: script.dataset.shown === '1', n,
      x: metres.subarray(0, n), y: metres.subarray(n, 2 * n), z: metres.subarray(2 * n), intensity: bytes.subarray(6 * n)};
  }
  makeRamp(stops) {
    const parts = stops.map(hex => [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16))), ramp = new Uint32Array(256);
    for (let i = 0; i < 256; ++i) {
      const at = i / 255 * (parts.length - 1), low = Math.min(Math.floor(at), parts.length - 2), share = at - low;
      const [r, g, b] = parts[low].map((value, c) => Math.round(value + share * (parts[low + 1][c] - value)));
      ramp[i] = 0xff000000 | b << 16 | g << 8 | r;
    }
    return ramp;
  }
  makeTools(tools) {
    for (const layer of this.layers) {
      const label = document.createElement('label'), box = document.createElement('input'), name = document.createElement('span');
      box.type = 'checkbox';
      box.checked = layer.isShown;
      box.onchange = () => { layer.isShown = box.checked; this.draw(); };
      name.textContent = ` ${layer.name}`;
      name.style.borderBottom = `3px solid ${layer.colour}`;
      label.append(box, name);
      tools.append(label);
    }
    const by = document.createElement('select');
    by.setAttribute('aria-label', 'colour');
    for (const name of ['layer', 'range', 'height', 'intensity']) by.add(new Option(`coloured by ${name}`, name));
    by.onchange = () => { this.by = by.value; this.draw(); };
    tools.append(by);
    const button = (text, act) => {
      const made = document.createElement('button');
      made.textContent = text;
      made.onclick = act;
      tools.append(made);
    };
    button('from behind', () => this.look(kBehind));
    button('from above', () => this.look(kAbove));
    button('nearer', () => this.zoom(0.8));
    button('farther', () => this.zoom(1.25));
  }
  look(view) {
    Object.assign(this, {yaw: view.yaw, pitch: view.pitch, away: view.away, at: [...view.at]});
    this.draw();
  }
  zoom(factor) {
    this.away = Math.min(Math.max(this.away * factor, 2), 400);
    this.draw();
  }
  turn(dx, dy) {
    this.yaw -= 0.006 * dx;
    this.pitch = Math.min(Math.max(this.pitch + 0.006 * dy, -0.2), 1.55);
    this.draw();
  }
  move(dx, dy) {
    const step = this.away / this.canvas.clientHeight, c = Math.cos(this.yaw), s = Math.sin(this.yaw);
    this.at[0] += step * (s * dx - c * dy);
    this.at[1] += step * (-c * dx - s * dy);
    this.draw();
  }
  listen() {
    const held = new Map(), canvas = this.canvas;
    const spread = () => {
      const [a, b] = [...held.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    canvas.addEventListener('pointerdown', e => {
      canvas.setPointerCapture(e.pointerId);
      held.set(e.pointerId, {x: e.clientX, y: e.clientY});
    });
    canvas.addEventListener('pointermove', e => {
      const last = held.get(e.pointerId);
      if (!last) return;
      const before = held.size === 2 ? spread() : 0, dx = e.clientX - last.x, dy = e.clientY - last.y;
      held.set(e.pointerId, {x: e.clientX, y: e.clientY});
      if (held.size === 2) this.zoom(before / Math.max(spread(), 1));
      else if (e.shiftKey || e.buttons & 2) this.move(dx, dy);
      else this.turn(dx, dy);
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, e => held.delete(e.pointerId));
    canvas.addEventListener('contextmenu', e => e.preventDefault());
    // The page scrolls until the cloud is clicked.
    canvas.addEventListener('wheel', e => {
      if (document.activeElement !== canvas) return;
      e.preventDefault();
      this.zoom(Math.exp(0.001 * e.deltaY));
    }, {passive: false});
    canvas.addEventListener('keydown', e => {
      const turns = {ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, 20], ArrowDown: [0, -20]}[e.key];
      if (turns) this.turn(...turns);
      else if (e.key === '+' || e.key === '-') this.zoom(e.key === '+' ? 0.8 : 1.25);
      else return;
      e.preventDefault();
    });
    new ResizeObserver(() => this.draw()).observe(canvas);
    const paper = light => { this.isLight = light; this.draw(); };
    addEventListener('beforeprint', () => paper(true));
    addEventListener('afterprint', () => paper(false));
  }
  colours(layer) {
    const flat = colourOf(layer.colour), ramp = this.ramp, {x, y, z, intensity} = layer, ground = this.ground;
    const place = v => ramp[Math.min(Math.max(Math.round(255 * v), 0), 255)];
    return {layer: () => flat,
      range: i => place(Math.log(Math.max(Math.hypot(x[i], y[i], z[i]), 2) / 2) / Math.log(50)),
      height: i => place(1 - (z[i] - ground) / 8),
      intensity: i => place(1 - Math.sqrt(intensity[i] / 255))}[this.by];
  }
  draw() {
    const canvas = this.canvas, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
    if (w === 0 || h === 0) return;
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const cy = Math.cos(this.yaw), sy = Math.sin(this.yaw), cp = Math.cos(this.pitch), sp = Math.sin(this.pitch);
    const forward = [-cp * cy, -cp * sy, -sp], right = [-sy, cy, 0], up = [-sp * cy, -sp * sy, cp];
    const eye = this.at.map((value, k) => value - this.away * forward[k]), focal = 0.9 * Math.min(w, 1.4 * h);
    const image = this.context.createImageData(w, h), pixels = new Uint32Array(image.data.buffer);
    const depth = new Float32Array(w * h).fill(Infinity);
    pixels.fill(this.isLight ? 0xffffffff : 0xff100d0b);
    for (const layer of this.layers) {
      if (!layer.isShown) continue;
      const colour = this.colours(layer);
      for (let i = 0; i < layer.n; ++i) {
        const dx = layer.x[i] - eye[0], dy = layer.y[i] - eye[1], dz = layer.z[i] - eye[2];
        const far = dx * forward[0] + dy * forward[1] + dz * forward[2];
        if (far < 0.5) continue;
        const u = Math.round(w / 2 + focal * (dx * right[0] + dy * right[1]) / far);
        const v = Math.round(h / 2 - focal * (dx * up[0] + dy * up[1] + dz * up[2]) / far);
        const size = Math.ceil(ratio * (far < 25 ? 2 : 1.2));
        if (u < 0 || v < 0 || u + size > w || v + size > h) continue;
        const tint = colour(i);
        for (let b = 0; b < size; ++b) {
          for (let k = (v + b) * w + u, end = k + size; k < end; ++k) {
            if (far >= depth[k]) continue;
            depth[k] = far;
            pixels[k] = tint;
          }
        }
      }
    }
    this.context.putImageData(image, 0, 0);
    this.drawLines(p => {
      const d = p.map((value, k) => value - eye[k]), far = d[0] * forward[0] + d[1] * forward[1] + d[2] * forward[2];
      const along = axis => d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
      return far < 0.5 ? null : [w / 2 + focal * along(right) / far, h / 2 - focal * along(up) / far];
    }, ratio);
    canvas.dataset.frames = +(canvas.dataset.frames || 0) + 1;
  }
  drawLines(project, ratio) {
    const c = this.context;
    const path = points => {
      c.beginPath();
      let last = null;
      for (const p of points) {
        const at = project(p);
        if (at && last) c.lineTo(...at);
        else if (at) c.moveTo(...at);
        last = at;
      }
      c.stroke();
    };
    c.lineWidth = ratio;
    c.strokeStyle = c.fillStyle = this.isLight ? '#0006' : '#fff6';
    c.font = `${Math.round(11 * ratio)}px system-ui, sans-serif`;
    for (const radius of kRings_m) {
      const at = k => [radius * Math.cos(k * Math.PI / 48), radius * Math.sin(k * Math.PI / 48), this.ground];
      path(Array.from({length: 97}, (_, k) => at(k)));
      const label = project(at(0));
      if (label) c.fillText(`${radius} m`, ...label);
    }
    c.strokeStyle = '#ff8a3d';
    for (const box of this.boxes) {
      for (let k = 0; k < 8; ++k) {
        for (const side of [1, 2, 4]) if (!(k & side)) path([box[k], box[k | side]]);
      }
    }
  }
}
for (const figure of document.querySelectorAll('.cloud')) new Cloud(figure);
