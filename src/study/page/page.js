// Makes charts and pictures of fields answer. The page reads without it: drawings and pictures stay in place for
// print and for readers without scripts.
(() => {
'use strict';

const make = (tag, own = {}, children = []) => {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(own)) {
    if (key in node) node[key] = value; else node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
};
const button = (words, press, label) => {
  const node = make('button', {type: 'button', onclick: press}, words);
  if (label) node.setAttribute('aria-label', label);
  return node;
};
const press = (node, on) => node.setAttribute('aria-pressed', String(on));

// Five digits, with a power of ten where numbers are long.
const digits = value => {
  if (value === null || !Number.isFinite(value)) return 'no value';
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(4).replaceAll('-', '−').replace('e+', 'e');
  return String(Number(value.toPrecision(5))).replace('-', '−');
};
const withUnit = (value, unit) => unit && unit !== '1' ? `${digits(value)} ${unit}` : digits(value);

// ---------------------------------------------------------------- charts

const MARKS = ['circle', 'rect', 'triangle', 'rectRot', 'star', 'cross', 'crossRot'];
const DASHES = [[9, 5], [3, 4], [12, 4, 3, 4], [18, 6]];

// Series without a label look as the one before and belong to it.
function groupsOf(data) {
  const groups = new Map();
  for (const series of data.series) {
    const known = groups.get(series.group);
    if (!known) groups.set(series.group, {label: series.label, series: [series]});
    else { known.series.push(series); known.label = known.label || series.label; }
  }
  return groups;
}

// At logarithmic axes powers of ten alone, if two of them are in sight.
const raised = power => String(power).replace(/./g, own => own === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[own]);
const powerOf = value => {
  const power = Math.log10(value);
  return Math.abs(power - Math.round(power)) < 1e-9 ? Math.round(power) : null;
};
function mark(value, ticks, log) {
  const power = log ? powerOf(value) : null;
  if (log && power === null && ticks.filter(tick => powerOf(tick.value) !== null).length > 1) return null;
  return power !== null && Math.abs(power) > 3 ? `10${raised(power)}` : digits(value);
}

function dataset(series, label, hidden) {
  const marked = series.style === 'markers';
  return {
    label, group: series.group, hidden,
    data: series.x.map((x, k) => ({x: x === null ? NaN : x, y: series.y[k] === null ? NaN : series.y[k]})),
    showLine: !marked, borderColor: series.colour, backgroundColor: series.colour,
    borderWidth: series.style === 'thin' ? 1 : 2.5,
    borderDash: series.style === 'dashed' ? DASHES[series.group % DASHES.length] : [],
    pointStyle: MARKS[series.mark],
    pointRadius: marked ? 5 : 0, pointHoverRadius: 7, pointHitRadius: 10,
  };
}

class LiveChart {
  constructor(figure, data) {
    this.data = data;
    this.groups = groupsOf(data);
    this.hidden = new Set();
    this.log = {x: data.x.log, y: data.y.log};
    this.range = {};
    this.at = null;
    this.canvas = make('canvas', {tabIndex: 0, role: 'img'});
    this.canvas.setAttribute('aria-label', `${data.title}. Arrow keys read values off, + and − zoom, 0 shows all.`);
    this.plot = make('div', {className: 'plot'}, [this.canvas]);
    this.readout = make('output', {className: 'readout'});
    const root = make('div', {className: 'live chart'}, [
      make('p', {className: 'name', textContent: data.title}), this.tools(), this.plot, this.readout]);
    figure.prepend(root);
    figure.classList.add('has-live');
    root.chart = this;
    this.listen();
    this.draw();
    this.say();
  }

  tools() {
    const nodes = [];
    for (const [group, {label, series}] of this.groups) {
      if (!label) continue;
      const kind = series.some(own => own.style === 'markers') ? 'markers' : series[0].style;
      const swatch = make('span', {className: `swatch ${kind}`, style: `border-color:${series[0].colour}`});
      const node = button([swatch, make('span', {className: 'what', textContent: label})], () => this.toggle(group, node));
      press(node, true);
      node.dataset.group = group;
      nodes.push(node);
    }
    for (const axis of ['x', 'y']) {
      const node = button([`log ${axis}`], () => this.toggleLog(axis, node));
      press(node, this.log[axis]);
      node.dataset.log = axis;
      const positive = this.data.series.some(own => own[axis].some(value => value !== null && value > 0));
      node.disabled = !positive;
      nodes.push(node);
    }
    nodes.push(button(['+'], () => this.zoom(0.5), 'zoom in'), button(['−'], () => this.zoom(2), 'zoom out'),
      button(['all'], () => this.reset(), 'show all'));
    return make('div', {className: 'tools'}, nodes);
  }

  name(axis) {
    const {name, unit} = this.data[axis];
    return unit ? `${name} [${unit}]` : name;
  }

  draw() {
    if (this.chart) this.chart.destroy();
    const scale = axis => ({
      type: this.log[axis] ? 'logarithmic' : 'linear',
      title: {display: true, text: this.name(axis)}, ...this.range[axis],
      ticks: {maxRotation: 0, autoSkipPadding: 14, callback: (value, _, ticks) => mark(value, ticks, this.log[axis])},
    });
    const datasets = [];
    for (const [group, {label, series}] of this.groups) {
      for (const own of series) datasets.push(dataset(own, label, this.hidden.has(group)));
    }
    this.chart = new Chart(this.canvas, {
      type: 'scatter', data: {datasets},
      options: {
        animation: false, maintainAspectRatio: false, responsive: true, spanGaps: false,
        interaction: {mode: 'nearest', axis: 'xy', intersect: false},
        scales: {x: scale('x'), y: scale('y')},
        plugins: {legend: {display: false}, tooltip: {callbacks: {label: item => this.words(item.datasetIndex, item.dataIndex)}}},
        onHover: (_, found) => { if (found.length) this.read(found[0].datasetIndex, found[0].index); },
      },
    });
  }

  words(set, index) {
    const {label, data} = this.chart.data.datasets[set];
    const {x, y} = data[index];
    const of = label ? `${label}: ` : '';
    return `${of}${this.data.x.name} ${withUnit(x, this.data.x.unit)}, ${this.data.y.name} ${withUnit(y, this.data.y.unit)}`;
  }

  read(set, index) {
    this.at = [set, index];
    this.readout.textContent = this.words(set, index);
  }

  say() {
    const some = this.data.series.filter(own => own.x.length < own.of);
    const lost = axis => this.log[axis] ? this.data.series.flatMap(own => own[axis]).filter(v => v !== null && v <= 0).length : 0;
    const notes = some.map(own => `${own.x.length} of ${own.of} values are here`);
    const gone = lost('x') + lost('y');
    if (gone) notes.push(`${gone} values ≤ 0 have no place on the logarithmic axis`);
    this.readout.textContent = notes.join('; ');
  }

  toggle(group, node) {
    const hide = !this.hidden.has(group);
    if (hide) this.hidden.add(group); else this.hidden.delete(group);
    press(node, !hide);
    this.draw();
  }

  toggleLog(axis, node) {
    this.log[axis] = !this.log[axis];
    press(node, this.log[axis]);
    this.range = {};
    this.draw();
    this.say();
  }

  reset() { this.range = {}; this.draw(); }

  // About the value that is read off, else about the middle.
  zoom(factor) {
    const point = this.at && this.chart.data.datasets[this.at[0]].data[this.at[1]];
    for (const axis of ['x', 'y']) {
      const scale = this.chart.scales[axis];
      const [from, to] = axis === 'x' ? [scale.left, scale.right] : [scale.bottom, scale.top];
      const shown = point && point[axis] >= scale.min && point[axis] <= scale.max;
      const middle = shown ? scale.getPixelForValue(point[axis]) : (from + to) / 2;
      const ends = [from, to].map(end => scale.getValueForPixel(middle + factor * (end - middle)));
      this.range[axis] = {min: Math.min(...ends), max: Math.max(...ends)};
    }
    this.draw();
  }

  listen() {
    let start = null;
    const box = make('div', {className: 'box', hidden: true});
    this.plot.append(box);
    const place = event => {
      const {left, top} = this.canvas.getBoundingClientRect();
      return [event.clientX - left, event.clientY - top];
    };
    this.canvas.addEventListener('pointerdown', event => {
      if (event.pointerType === 'touch' || event.button !== 0) return;
      start = place(event);
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener('pointermove', event => {
      if (!start) return;
      const end = place(event);
      box.hidden = false;
      for (const [k, [near, size]] of [[0, ['left', 'width']], [1, ['top', 'height']]]) {
        box.style[near] = `${Math.min(start[k], end[k])}px`;
        box.style[size] = `${Math.abs(start[k] - end[k])}px`;
      }
    });
    this.canvas.addEventListener('pointerup', event => {
      const from = start;
      start = null;
      box.hidden = true;
      if (from) this.show(from, place(event));
    });
    this.canvas.addEventListener('pointercancel', () => { start = null; box.hidden = true; });
    this.canvas.addEventListener('dblclick', () => this.reset());
    this.canvas.addEventListener('keydown', event => this.key(event));
  }

  // What was framed; less than eight pixels are a click.
  show(from, to) {
    if (Math.abs(from[0] - to[0]) < 8 || Math.abs(from[1] - to[1]) < 8) return;
    for (const [k, axis] of [[0, 'x'], [1, 'y']]) {
      const ends = [from[k], to[k]].map(pixel => this.chart.scales[axis].getValueForPixel(pixel));
      this.range[axis] = {min: Math.min(...ends), max: Math.max(...ends)};
    }
    this.draw();
  }

  key(event) {
    const keys = {
      ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1),
      ArrowDown: () => this.next(1), ArrowUp: () => this.next(-1),
      '+': () => this.zoom(0.5), '-': () => this.zoom(2), '0': () => this.reset(),
    };
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  }

  usable(set) { return this.chart.isDatasetVisible(set) ? this.chart.data.datasets[set].data : []; }

  step(by) {
    const sets = this.chart.data.datasets.length;
    let [set, index] = this.at || [0, -by];
    if (!this.usable(set).length) { this.next(1); return; }
    const data = this.usable(set);
    do index += by; while (index >= 0 && index < data.length && !(Number.isFinite(data[index].x) && Number.isFinite(data[index].y)));
    if (sets && index >= 0 && index < data.length) this.point(set, index);
  }

  next(by) {
    const sets = this.chart.data.datasets.length;
    let set = this.at ? this.at[0] : -by;
    for (let tries = 0; tries < sets; tries++) {
      set = (set + by + sets) % sets;
      const index = this.usable(set).findIndex(own => Number.isFinite(own.x) && Number.isFinite(own.y));
      if (index >= 0) { this.point(set, index); return; }
    }
  }

  point(set, index) {
    this.read(set, index);
    const found = [{datasetIndex: set, index}];
    this.chart.setActiveElements(found);
    this.chart.tooltip.setActiveElements(found, {x: 0, y: 0});
    this.chart.update();
  }
}

// ---------------------------------------------------------------- fields

const floats = async text => {
  const bytes = Uint8Array.from(atob(text), own => own.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Float32Array(await new Response(stream).arrayBuffer());
};

class Field {
  constructor(root, all) {
    this.all = all;
    this.figures = [...root.querySelectorAll('figure')];
    this.readout = make('output', {className: 'readout'});
    this.root = root;
    root.append(this.readout);
    for (const figure of this.figures) {
      figure.facts = figure.dataset.facts ? JSON.parse(figure.dataset.facts) : null;
      const image = figure.querySelector('img');
      const view = make('div', {className: 'view', tabIndex: 0, role: 'application'});
      view.setAttribute('aria-label', `${image.alt}. Arrow keys move the place whose values are read off, + and − zoom, 0 shows all.`);
      image.replaceWith(view);
      view.append(image);
      figure.view = view;
      figure.image = image;
      view.addEventListener('pointermove', event => this.hover(figure, event));
      view.addEventListener('keydown', event => this.key(figure, event));
    }
  }

  get shown() { return this.figures.find(figure => !figure.hidden); }

  show(output) {
    for (const figure of this.figures) figure.hidden = figure.dataset.output !== output;
  }

  hover(figure, event) {
    if (!figure.facts) return;
    const {left, top, width, height} = figure.image.getBoundingClientRect();
    const {size, frame, window: [x0, x1, y0, y1]} = figure.facts;
    const across = ((event.clientX - left) / width * size[0] - frame[0]) / frame[2];
    const down = ((event.clientY - top) / height * size[1] - frame[1]) / frame[3];
    if (across < 0 || across > 1 || down < 0 || down > 1) return;
    this.all.look(figure.facts.axes, [x0 + across * (x1 - x0), y1 - down * (y1 - y0)]);
  }

  key(figure, event) {
    const steps = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
    const step = steps[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (step && figure.facts) {
      const [x0, x1, y0, y1] = figure.facts.window;
      const axes = figure.facts.axes.join('');
      const [x, y] = this.all.at && this.all.at.axes === axes ? this.all.at.place : [(x0 + x1) / 2, (y0 + y1) / 2];
      const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
      this.all.look(figure.facts.axes, [clamp(x + step[0] * (x1 - x0) / 50, x0, x1), clamp(y + step[1] * (y1 - y0) / 50, y0, y1)]);
    } else if (event.key === '+') this.all.zoom(2);
    else if (event.key === '-') this.all.zoom(0.5);
    else if (event.key === '0') this.all.zoom(0);
    else return;
    event.preventDefault();
  }

  // Values at a place, if the picture is one over these axes.
  async read(axes, place) {
    const figure = this.shown;
    if (!figure || !figure.facts || figure.facts.axes.join('') !== axes) { this.readout.textContent = ''; return; }
    if (!figure.dataset.values) { this.readout.textContent = 'no values on this page'; return; }
    try {
      const places = await this.all.places(axes);
      figure.values = figure.values || await floats(figure.dataset.values);
      if (this.shown !== figure) return;
      let best = -1, least = Infinity;
      for (let k = 0; k < figure.values.length; k++) {
        const distance = (places[2 * k] - place[0]) ** 2 + (places[2 * k + 1] - place[1]) ** 2;
        if (distance < least) { least = distance; best = k; }
      }
      if (best < 0) return;
      const [x, y] = [places[2 * best], places[2 * best + 1]];
      const [a, b] = figure.facts.axes;
      this.readout.textContent =
        `${withUnit(figure.values[best], figure.facts.unit)} at the point ${a} = ${digits(x)} m, ${b} = ${digits(y)} m`;
      this.mark(figure, [x, y]);
    } catch (error) {
      this.readout.textContent = `this browser cannot unpack the values (${error.message})`;
    }
  }

  mark(figure, [x, y]) {
    figure.spot = figure.spot || figure.view.appendChild(make('div', {className: 'spot'}));
    const {size, frame, window: [x0, x1, y0, y1]} = figure.facts;
    const across = (frame[0] + (x - x0) / (x1 - x0) * frame[2]) / size[0];
    const down = (frame[1] + (y1 - y) / (y1 - y0) * frame[3]) / size[1];
    const {scale, centre} = this.all;
    figure.spot.style.left = `${100 * ((across - centre[0]) * scale + centre[0])}%`;
    figure.spot.style.top = `${100 * ((down - centre[1]) * scale + centre[1])}%`;
  }

  transform() {
    const {scale, centre} = this.all;
    for (const figure of this.figures) {
      figure.image.style.transformOrigin = `${100 * centre[0]}% ${100 * centre[1]}%`;
      figure.image.style.transform = scale === 1 ? '' : `scale(${scale})`;
      figure.view.classList.toggle('near', scale > 2);
    }
  }
}

class Fields {
  constructor(section) {
    this.scale = 1;
    this.centre = [0.5, 0.5];
    this.at = null;
    this.known = new Map();
    for (const own of section.querySelectorAll('[data-places]')) this.known.set(own.dataset.axes, own.dataset.places);
    this.fields = [...section.querySelectorAll('.field')].map(root => new Field(root, this));
    const figures = this.fields.flatMap(field => field.figures);
    this.outputs = [...new Set(figures.map(figure => figure.dataset.output))].sort((a, b) => a - b);
    this.times = this.outputs.map(output => {
      const told = figures.find(figure => figure.dataset.output === output && figure.facts && figure.facts.time !== null);
      return told ? told.facts.time : null;
    });
    section.classList.add('grid');
    section.before(this.tools());
    this.show(this.outputs.length - 1);
  }

  tools() {
    this.input = make('input', {type: 'range', min: 0, max: this.outputs.length - 1, step: 1});
    this.input.setAttribute('aria-label', 'output shown');
    this.input.addEventListener('input', () => this.show(Number(this.input.value)));
    this.label = make('output', {className: 'time'});
    this.player = button(['play'], () => this.play());
    const nodes = this.outputs.length > 1 ? [this.player, this.input, this.label] : [this.label];
    nodes.push(button(['+'], () => this.zoom(2), 'zoom in'), button(['−'], () => this.zoom(0.5), 'zoom out'),
      button(['all'], () => this.zoom(0), 'show all'));
    return make('div', {className: 'tools slider'}, nodes);
  }

  show(place) {
    this.input.value = place;
    const output = this.outputs[place];
    for (const field of this.fields) field.show(output);
    const time = this.times[place];
    const number = `output ${place + 1} of ${this.outputs.length}`;
    this.label.textContent = time === null ? number : `${number}, t = ${digits(time)} s`;
    if (this.at) this.look([...this.at.axes], this.at.place);
  }

  play() {
    if (this.timer) { clearInterval(this.timer); this.timer = null; this.player.textContent = 'play'; return; }
    this.player.textContent = 'stop';
    this.timer = setInterval(() => this.show((Number(this.input.value) + 1) % this.outputs.length), 600);
  }

  look(axes, place) {
    this.at = {axes: axes.join(''), place};
    return Promise.all(this.fields.map(field => field.read(this.at.axes, place)));
  }

  places(axes) {
    const known = this.known.get(axes);
    if (typeof known === 'string') this.known.set(axes, floats(known));
    return this.known.get(axes);
  }

  // About the place that is read off, else about the middle of the picture; zero shows all.
  zoom(factor) {
    const figure = this.fields.map(field => field.shown).find(own => own && own.facts && this.at && own.facts.axes.join('') === this.at.axes);
    if (figure) {
      const {size, frame, window: [x0, x1, y0, y1]} = figure.facts;
      const [x, y] = this.at.place;
      this.centre = [(frame[0] + (x - x0) / (x1 - x0) * frame[2]) / size[0], (frame[1] + (y1 - y) / (y1 - y0) * frame[3]) / size[1]];
    }
    this.scale = factor === 0 ? 1 : Math.min(Math.max(this.scale * factor, 1), 16);
    for (const field of this.fields) field.transform();
    if (this.at) this.look([...this.at.axes], this.at.place);
  }
}

const begin = () => {
  for (const metadata of document.querySelectorAll('figure svg metadata')) {
    const figure = metadata.closest('figure');
    if (typeof Chart === 'undefined' || figure.classList.contains('has-live')) continue;
    try {
      new LiveChart(figure, JSON.parse(metadata.textContent));
    } catch (error) {
      console.error(error);
    }
  }
  for (const section of document.querySelectorAll('section.fields')) {
    if (section.querySelector('figure')) section.fields = new Fields(section);
  }
};
if (document.readyState === 'loading') document.addEventListener('DOMContentLoaded', begin); else begin();
})();
