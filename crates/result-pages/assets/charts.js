"use strict";
// Charts: lines by uPlot; errors and ranges are drawn over them, and a readout has the values under the pointer.
{
  // After Okabe and Ito; black is the ink of the theme.
  const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8f7f00", ""];
  const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3]];
  const MOST_BARS = 60;
  const data = JSON.parse(document.getElementById("data").textContent);
  const colourOf = (k) => COLOURS[k % COLOURS.length] || theme.colour("--ink");

  const draw = (place) => {
    const chart = data.charts[Number(place.dataset.chart)];
    const readout = place.parentElement.querySelector(".readout");
    // On a logarithmic scale a value that is smaller than its error has no place; the readout has it.
    const isShown = ({ y, error, bound }) =>
      !chart.is_logarithmic || (y > 0 && !(error >= y) && bound === undefined);
    // All series over the union of their abscissae.
    const xs = [...new Set(chart.series.flatMap((series) => series.points.map((point) => point.x)))].sort((a, b) => a - b);
    const at = new Map(xs.map((x, k) => [x, k]));
    const points = chart.series.map((series) => {
      const row = new Array(xs.length).fill(null);
      for (const point of series.points) row[at.get(point.x)] = point;
      return row;
    });
    const values = points.map((row) => row.map((point) => (point && isShown(point) ? point.y : null)));

    const show = (k) => {
      if (k === null || k === undefined) return;
      const lines = chart.series.map((series, s) => {
        const point = points[s][k];
        const item = document.createElement("li");
        const mark = document.createElement("i");
        mark.style.background = colourOf(s);
        item.append(mark, `${series.name}: `);
        if (point) {
          const how = point.how ? `, ${point.how}` : "";
          const spread = point.spread === undefined ? "" : `; ${chart.spread} ${short(point.spread)}`;
          const value =
            point.bound === undefined ? withError(point.y, point.error) : `< ${digits(point.bound, 2)}`;
          item.append(value + how + spread);
        } else {
          item.append("no value here");
        }
        return item;
      });
      const list = document.createElement("ul");
      list.append(...lines);
      const head = document.createElement("strong");
      head.textContent = `${chart.x_label}: ${Number(xs[k].toPrecision(6))}`;
      readout.replaceChildren(head, list);
    };

    // Ranges and errors of the points, clipped to the frame.
    const bars = (u) => {
      const { ctx, bbox } = u;
      ctx.save();
      ctx.beginPath();
      ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.clip();
      const floor = u.scales.y.min;
      const y = (value) => u.valToPos(chart.is_logarithmic && value <= 0 ? floor / 10 : value, "y", true);
      const x = (k) => u.valToPos(xs[k], "x", true);
      points.forEach((row, s) => {
        const seen = row.map((point, k) => (point && isShown(point) ? k : -1)).filter((k) => k >= 0);
        const shade = (half, alpha) => {
          const inside = seen.filter((k) => row[k][half] !== undefined);
          if (inside.length < 2) return;
          ctx.beginPath();
          inside.forEach((k, i) => ctx[i ? "lineTo" : "moveTo"](x(k), y(row[k].y + row[k][half])));
          [...inside].reverse().forEach((k) => ctx.lineTo(x(k), y(row[k].y - row[k][half])));
          ctx.closePath();
          ctx.globalAlpha = alpha;
          ctx.fillStyle = colourOf(s);
          ctx.fill();
          ctx.globalAlpha = 1;
        };
        shade("spread", 0.12);
        if (seen.length > MOST_BARS) return shade("error", 0.25);
        ctx.strokeStyle = colourOf(s);
        ctx.lineWidth = 1.2 * devicePixelRatio;
        for (const k of seen) {
          if (row[k].error === undefined) continue;
          const [low, high] = [y(row[k].y - row[k].error), y(row[k].y + row[k].error)];
          if (Math.abs(low - high) < 2) continue;
          ctx.beginPath();
          ctx.moveTo(x(k), low);
          ctx.lineTo(x(k), high);
          ctx.stroke();
        }
      });
      ctx.restore();
    };

    // The ordinate reaches the ends of errors and ranges; on a logarithmic scale not below a third of the value.
    const reach = () => {
      let [low, high] = [Infinity, -Infinity];
      for (const row of points) {
        for (const point of row) {
          if (!point || !isShown(point)) continue;
          const half = Math.max(point.error ?? 0, point.spread ?? 0);
          low = Math.min(low, chart.is_logarithmic ? Math.max(point.y - half, 0.3 * point.y) : point.y - half);
          high = Math.max(high, point.y + half);
        }
      }
      if (low > high) return [chart.is_logarithmic ? 0.1 : 0, 1];
      if (chart.is_logarithmic) {
        // Ends with one digit, so that the axis has round numbers.
        const unit = (value) => 10 ** Math.floor(Math.log10(value));
        return [Math.floor((0.999 * low) / unit(low)) * unit(low) || unit(low), Math.ceil((1.001 * high) / unit(high)) * unit(high)];
      }
      const room = 0.06 * (high - low) || Math.abs(high) || 1;
      return [low - room, high + room];
    };
    const range = reach();
    const ink = theme.colour("--ink");
    const axis = (label, size) => ({
      label, size, labelSize: 22, stroke: ink, grid: { stroke: theme.colour("--line"), width: 1 },
      ticks: { stroke: theme.colour("--line") }, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
    });
    const tick = (value) => {
      if (value === null) return "";
      const rounded = Number(value.toPrecision(4));
      const isSmall = rounded !== 0 && Math.abs(rounded) < 1e-3;
      return (isSmall ? rounded.toExponential() : rounded.toString()).replace("e+", "e");
    };
    const ticks = (u, splits) => splits.map(tick);
    // On a logarithmic axis the fewer decades, the more values have a label.
    const labelled = (u, splits) => {
      const decades = Math.log10(splits[splits.length - 1] / splits[0]);
      const kept = decades > 3 ? [1] : decades > 1 ? [1, 2, 5] : [1, 2, 3, 4, 5, 6, 7, 8, 9];
      const first = (value) => Math.round(value / 10 ** Math.floor(Math.log10(value) + 1e-9));
      return splits.map((value) => (kept.includes(first(value)) ? value : null));
    };
    const logarithmic = { values: ticks, filter: labelled };
    const width = () => Math.max(200, place.clientWidth);
    const u = new uPlot({
      width: width(),
      height: 280,
      padding: [12, 12, 0, 0],
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, y: false },
      scales: {
        x: chart.x_is_logarithmic ? { time: false, distr: 3 } : { time: false },
        y: chart.is_logarithmic ? { distr: 3, range: () => range } : { range: () => range },
      },
      axes: [
        { ...axis(chart.x_label, 40), ...(chart.x_is_logarithmic ? logarithmic : { values: ticks }) },
        { ...axis(chart.y_label, 62), ...(chart.is_logarithmic ? logarithmic : { values: ticks }) },
      ],
      series: [
        {},
        ...chart.series.map((series, s) => ({
          label: series.name,
          stroke: colourOf(s),
          width: 2,
          dash: DASHES[Math.floor(s / COLOURS.length) % DASHES.length],
          spanGaps: true,
          points: { show: xs.length <= MOST_BARS },
        })),
      ],
      hooks: { draw: [bars], setCursor: [(u) => show(u.cursor.idx)] },
    }, [xs, ...values], place);
    for (const canvas of place.querySelectorAll("canvas")) canvas.setAttribute("aria-hidden", "true");
    show(xs.length - 1);
    // A picture without a pointer has its last values; the arrow keys go from point to point.
    place.onkeydown = (event) => {
      const here = u.cursor.idx ?? xs.length - 1;
      const to = { ArrowLeft: here - 1, ArrowRight: here + 1, Home: 0, End: xs.length - 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      const k = Math.min(xs.length - 1, Math.max(0, to));
      u.setCursor({ left: u.valToPos(xs[k], "x"), top: 10 });
      show(k);
    };
    return { u, width };
  };

  const drawn = new Map();
  const all = () => {
    for (const place of document.querySelectorAll(".chart")) {
      drawn.get(place)?.u.destroy();
      drawn.set(place, draw(place));
    }
  };
  all();
  theme.onChange(all);
  addEventListener("resize", () => {
    for (const { u, width } of drawn.values()) u.setSize({ width: width(), height: 280 });
  });
}
