// SPDX-License-Identifier: BSD-3-Clause
// Draws the figures of a page with dygraphs, from the data beside each static drawing. Figures with the same "link"
// share cursor and zoom; paths show the cursor's place. Without this script the static drawings stay.
addEventListener('DOMContentLoaded', () => {
  const graphs = [], paths = [];
  const after = (xs, x) => {  // index of the first entry of increasing numbers that is not below x
    let low = 0, high = xs.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (xs[middle] < x) low = middle + 1; else high = middle;
    }
    return low;
  };
  const near = (xs, x) => {  // index of the entry nearest to x in increasing numbers
    const high = Math.min(after(xs, x), xs.length - 1);
    return high > 0 && x - xs[high - 1] < xs[high] - x ? high - 1 : high;
  };
  const short = value => value === null || value === undefined || Number.isNaN(value) ? '–'
    : Math.abs(value) >= 1000 ? value.toFixed(0) : String(Number(value.toPrecision(4)));

  // Indices of the curve's points in the window and one beside it: the smallest and the largest of each group of
  // neighbours, at most four points a pixel, as on the static drawing. A group with a gap keeps only the gap.
  function thinned({x, y}, window, pixels) {
    const begin = window ? Math.max(0, after(x, window[0]) - 1) : 0;
    const end = window ? Math.min(x.length, after(x, window[1]) + 2) : x.length;
    const group = Math.max(1, Math.ceil((end - begin) / (2 * pixels))), kept = [];
    for (let from = begin; from < end; from += group) {
      let low = from, high = from;
      for (let i = from; i < Math.min(from + group, end) && y[low] !== null; ++i) {
        if (y[i] === null || y[i] < y[low]) low = i;
        if (y[i] > y[high]) high = i;
      }
      if (y[low] === null || low === high) kept.push(low);
      else kept.push(Math.min(low, high), Math.max(low, high));
    }
    return kept;
  }
  // One row per x of any curve; null where a curve has no point, NaN where it is broken.
  function rowsOf(series, window, pixels) {
    const points = series.flatMap((one, k) => thinned(one, window, pixels).map(i => [one.x[i], k + 1, one.y[i]]));
    const rows = [];
    for (const [x, column, y] of points.sort((a, b) => a[0] - b[0])) {
      if (rows.length === 0 || rows.at(-1)[0] !== x) rows.push([x, ...series.map(() => null)]);
      rows.at(-1)[column] = y === null ? NaN : y;
    }
    return rows;
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
  // Takes the points that can be seen in the window; null: in the whole figure.
  function take(one, window, pixels) {
    one.window = window || one.all;
    one.rows = rowsOf(one.data.series, one.window, pixels);
    one.xs = one.rows.map(row => row[0]);
  }
  // Draws the window. A zoom in y stays until all is shown.
  function show(one, window) {
    const y = window ? one.graph.axes_[0].valueRange : one.range;  // yAxisRange() would be padded anew each time
    take(one, window, one.graph.getArea().w);
    one.graph.updateOptions({file: one.rows, dateWindow: one.window, valueRange: y});
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
    let shared = [];
    data.series.forEach(line => { shared = line.x = line.x || shared; });
    if (data.series.every(line => line.x.length === 0)) return;
    const keys = document.createElement('div'), plot = document.createElement('div');
    keys.className = 'keys';
    plot.className = 'plot';
    plot.style.height = `${data.height}px`;
    figure.querySelector('.static').after(keys, plot);
    const one = {data, values: [], at: document.createElement('span')};
    const options = {
      labels: ['x', ...data.series.map((line, k) => `${k} ${line.name}`)],
      xlabel: data.x, connectSeparatedPoints: true, highlightCircleSize: 4, xRangePad: 0, yRangePad: 12,
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
          const index = near(other.xs, x);
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
        const window = graph.isZoomed('x') ? graph.xAxisRange() : null;
        if (first || busy || (window && String(window) === String(one.window))) return;
        linked(one, other => show(other, window));
        busy = true;
        show(one, window);
        busy = false;
      }};
    one.range = null;  // the range of y; null: as the points need
    if (data.yrange && data.yrange[1] > data.yrange[0]) one.range = data.yrange;
    else if (data.levels.length > 0) {  // the levels are part of the picture, as on the static drawing
      const all = [...data.levels.map(level => level[0][0]), ...data.series.flatMap(line => line.y)].filter(Number.isFinite);
      const low = all.reduce((a, b) => Math.min(a, b)), high = all.reduce((a, b) => Math.max(a, b));
      one.range = [low - 0.06 * (high - low || 1), high + 0.06 * (high - low || 1)];
    }
    one.all = data.xrange && data.xrange[1] > data.xrange[0] ? data.xrange : null;
    options.valueRange = one.range;
    if (one.all) options.dateWindow = one.all;
    figure.classList.add('live');  // before the graph: it measures its width
    take(one, null, plot.clientWidth);
    one.graph = new Dygraph(plot, one.rows, options);
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

  // The names beside the figures are the legend; the library's own measures its width, and so lays the whole page out
  // anew, at each drawing of each figure.
  Dygraph.PLUGINS = Dygraph.PLUGINS.filter(plugin => plugin !== Dygraph.Plugins.Legend);
  for (const script of document.querySelectorAll('figure > script[type="application/json"]')) {
    const figure = script.parentElement, data = JSON.parse(script.textContent);
    if (data.path) addPath(figure, data); else addGraph(figure, data);
  }
  const hint = document.querySelector('.hint');
  if (hint && graphs.length > 0) hint.hidden = false;
  window.m100Graphs = graphs;  // for tests
});
