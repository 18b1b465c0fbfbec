'use strict';
// Overlaid pictures with a divider, pictures that open at full size, printing.

function partAt(pair, percent) {
  const at = Math.min(Math.max(percent, 0), 100);
  pair.style.setProperty('--at', at.toFixed(2) + '%');
  pair.setAttribute('aria-valuenow', Math.round(at));
}
function partUnder(pair, event) {
  const box = pair.getBoundingClientRect();
  partAt(pair, 100 * (event.clientX - box.left) / box.width);
}
document.addEventListener('pointerdown', e => {
  const pair = e.target.closest('.pair');
  if (!pair || e.button !== 0) return;
  pair.setPointerCapture(e.pointerId);
  partUnder(pair, e);
});
document.addEventListener('pointermove', e => {
  const pair = e.buttons & 1 ? e.target.closest?.('.pair') : null;
  if (pair) partUnder(pair, e);
});
document.addEventListener('keydown', e => {
  const pair = e.target.closest?.('.pair'), step = {ArrowLeft: -5, ArrowRight: 5}[e.key];
  if (!pair || !step) return;
  partAt(pair, (parseFloat(pair.style.getPropertyValue('--at')) || 50) + step);
  e.preventDefault();
});

// One dialog for all enlarged figures.
const large = document.createElement('dialog');
large.className = 'large';
large.innerHTML = '<div class="stage"></div><p><span></span><button data-size>full size</button>' +
  '<button data-close autofocus>close</button></p>';
document.body.append(large);
const stage = large.querySelector('.stage');
let shown = null, isFull = false;

function fitShown() {
  if (!shown) return;
  const picture = shown.matches('img, svg') ? shown : shown.querySelector('img');
  const w = +picture.getAttribute('width'), h = +picture.getAttribute('height');
  const fit = Math.min(stage.clientWidth, stage.clientHeight * w / h);
  shown.style.width = Math.floor(isFull ? Math.max(w, 2.5 * fit) : fit) + 'px';
  stage.classList.toggle('full', isFull);
  large.querySelector('[data-size]').textContent = isFull ? 'fit' : 'full size';
}
function setFull(full) {
  isFull = full;
  fitShown();
}
function openLarge(figure) {
  shown = figure.querySelector('.pair, img, svg').cloneNode(true);
  shown.style.maxWidth = 'none';
  stage.replaceChildren(shown);
  large.querySelector('p span').textContent = figure.querySelector('figcaption').textContent;
  large.showModal();
  setFull(false);
}
for (const shot of document.querySelectorAll('.pictures .shot')) {
  const button = document.createElement('button');
  button.className = 'enlarge';
  button.textContent = '⤢';
  button.title = 'enlarge';
  button.setAttribute('aria-label', 'enlarge');
  shot.append(button);
}
document.addEventListener('click', e => {
  const figure = e.target.closest('.pictures figure, .charts figure');
  if (figure && (e.target.closest('.enlarge') || (e.target.closest('img, svg') && !e.target.closest('.pair')))) {
    openLarge(figure);
  }
});
large.addEventListener('click', e => {
  if (e.target.closest('[data-close]') || e.target === stage) large.close();
  else if (e.target.closest('[data-size]') || (e.target.closest('.stage') && !e.target.closest('.pair'))) setFull(!isFull);
});
large.addEventListener('close', () => {
  // The event is fired after the dialog has closed: another figure may be open.
  if (large.open) return;
  shown = null;
  stage.replaceChildren();
});
addEventListener('resize', fitShown);
