// SPDX-License-Identifier: BSD-3-Clause
// Draws the figures of a page with dygraphs, from the data beside each static drawing. Figures with the same "link"
// share cursor and zoom; paths show the cursor's place. Without this script the static drawings stay.
addEventListener('DOMContentLoaded', () => {
  const graphs = [], paths = [];
  const near = (xs, x) => {  // index of the entry nearest to x in increasing numbers
    let low = 0, high = xs.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] < x) low = middle; else high = middle;
    }
    return high > 0 && x - xs[low] > xs[high] - x ? high : low;
  };
  const short = value => value === null || value === undefined || Number.isNaN(value) ? '–'
    : Math.abs(value) >= 1000 ? value.toFixed(0) : String(Number(value.toPrecision(4)));

  // One row per x of any curve; null where a curve has no point, NaN where it is broken.
  function rowsOf(series) {
    let x = [];
    series.forEach(one => { x = one.x = one.x || x; });
    const rows = new Map();
    series.forEach((one, k) => one.x.forEach((at, i) => {
      if (!rows.has(at)) rows.set(at, [at, ...series.map(() => null)]);
      rows.get(at)[k + 1] = one.y[i] === null ? NaN : one.y[i];
    }));
    return [...rows.values()].sort((a, b) => a[0] - b[0]);
  }

  function underlay(data) {
    return (canvas, area, graph) => {
      canvas.save();
      canvas.font = '12px sans-serif';
      for (const [[from, to], label, color] of data.spans) {
        const left = Math.max(area.x, graph.toDomXCoord(from));
        const right = Math.min(area.x + area.w, graph.toDomXCoord(to));
        if (right <= left) continue;
        canvas.fillStyle = color;
        canvas.fillRect(left, area.y, right - left, area.h);
        canvas.fillStyle = '#555';
        if (canvas.measureText(label).width < right - left - 6) canvas.fillText(label, left + 4, area.y + 14);
      }
      for (const [[level], label] of data.levels) {
        const y = graph.toDomYCoord(level);
        if (y < area.y || y > area.y + area.h) continue;
        canvas.strokeStyle = '#9a9a9a';
        canvas.setLineDash([3, 3]);
        canvas.beginPath();
        canvas.moveTo(area.x, y);
        canvas.lineTo(area.x + area.w, y);
        canvas.stroke();
        canvas.fillStyle = '#555';
        canvas.fillText(label, area.x + area.w - canvas.measureText(label).width - 4, y - 4);
      }
      canvas.restore();
    };
  }

  let busy = false;  // a linked figure must not answer the change that it was given
  function linked(source, act) {
    if (busy) return;
    busy = true;
    for (const one of graphs) if (one !== source && source.data.link && one.data.link === source.data.link) act(one);
    busy = false;
  }
  function showValues(one, row) {
    one.values.forEach((cell, k) => { cell.textContent = row === null ? '' : short(one.rows[row][k + 1]); });
    one.at.textContent = row === null ? '' : `${one.data.x.replace(/ *\[.*/, '')} ${short(one.rows[row][0])}`;
  }
  function point(link, x) {
    for (const path of paths) if (path.link === link) {
      const index = x === null ? -1 : near(path.t, x);
      for (const {circle, map} of path.circles) {
        circle.setAttribute('visibility', index < 0 ? 'hidden' : 'visible');
        if (index >= 0) {
          circle.setAttribute('cx', map[0] + map[1] * path.x[index]);
          circle.setAttribute('cy', map[2] + map[3] * path.y[index]);
        }
      }
    }
  }

  function addPath(figure, data) {
    for (const line of data.series) if (line.t) {
      const circles = [...figure.querySelectorAll('svg[data-map]')].map(svg => {
        const circle = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
        for (const [key, value] of Object.entries({r: 5, fill: line.color, stroke: '#fff', visibility: 'hidden'}))
          circle.setAttribute(key, value);
        svg.append(circle);
        return {circle, map: svg.dataset.map.split(' ').map(Number)};
      });
      paths.push({link: data.link, t: line.t, x: line.x, y: line.y, circles});
    }
  }

  function addGraph(figure, data) {
    const rows = rowsOf(data.series);
    if (rows.length === 0) return;
    const keys = document.createElement('div'), plot = document.createElement('div');
    keys.className = 'keys';
    plot.className = 'plot';
    plot.style.height = `${data.height}px`;
    figure.querySelector('.static').after(keys, plot);
    const one = {data, rows, values: [], at: document.createElement('span')};
    const options = {
      labels: ['x', ...data.series.map((line, k) => `${k} ${line.name}`)],
      xlabel: data.x, legend: 'never', connectSeparatedPoints: true, highlightCircleSize: 4, xRangePad: 0, yRangePad: 12,
      axisLabelFontSize: 12, xLabelHeight: 18, gridLineColor: '#e6e6e6', axisLineColor: '#888', labelsKMB: false,
      axes: {y: {axisLabelWidth: 52, pixelsPerLabel: 26, axisLabelFormatter: value => short(value)}, x: {pixelsPerLabel: 50}},
      underlayCallback: underlay(data),
      series: Object.fromEntries(data.series.map((line, k) => [`${k} ${line.name}`, {
        color: line.color, strokeWidth: line.width, strokePattern: line.dashed ? [6, 4] : null,
        drawPoints: line.y.length < 30, pointSize: 3}])),
      highlightCallback: (event, x, points, row) => {
        showValues(one, row);
        point(data.link, x);
        linked(one, other => {
          const index = near(other.rows.map(r => r[0]), x);
          other.graph.setSelection(index);
          showValues(other, index);
        });
      },
      unhighlightCallback: () => {
        showValues(one, null);
        point(data.link, null);
        linked(one, other => { other.graph.clearSelection(); showValues(other, null); });
      },
      drawCallback: (graph, first) => {
        if (first) return;
        const zoomed = graph.isZoomed('x'), window = graph.xAxisRange();
        linked(one, other => other.graph.updateOptions({dateWindow: zoomed ? window : other.all}));
      }};
    if (data.yrange && data.yrange[1] > data.yrange[0]) options.valueRange = data.yrange;
    else if (data.levels.length > 0) {  // the levels are part of the picture, as on the static drawing
      const all = [...data.levels.map(level => level[0][0]), ...data.series.flatMap(line => line.y)].filter(Number.isFinite);
      const low = all.reduce((a, b) => Math.min(a, b)), high = all.reduce((a, b) => Math.max(a, b));
      options.valueRange = [low - 0.06 * (high - low || 1), high + 0.06 * (high - low || 1)];
    }
    one.all = data.xrange && data.xrange[1] > data.xrange[0] ? data.xrange : null;
    if (one.all) options.dateWindow = one.all;
    figure.classList.add('live');  // before the graph: it measures its width
    one.graph = new Dygraph(plot, rows, options);
    data.series.forEach((line, k) => {
      const label = document.createElement('label'), box = document.createElement('input');
      const swatch = document.createElement('i'), value = document.createElement('b');
      box.type = 'checkbox';
      box.checked = true;
      box.addEventListener('change', () => one.graph.setVisibility(k, box.checked));
      swatch.style.borderTop = `3px ${line.dashed ? 'dashed' : 'solid'} ${line.color}`;
      one.values.push(value);
      label.append(box, swatch, line.name || 'value', ' ', value);
      keys.append(label);
    });
    keys.append(one.at);
    graphs.push(one);
  }

  for (const script of document.querySelectorAll('figure > script[type="application/json"]')) {
    const figure = script.parentElement, data = JSON.parse(script.textContent);
    if (data.path) addPath(figure, data); else addGraph(figure, data);
  }
  const hint = document.querySelector('.hint');
  if (hint && graphs.length > 0) hint.hidden = false;
  window.m100Graphs = graphs;  // for tests
});
