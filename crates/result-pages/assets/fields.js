"use strict";
// Fields: cells or particles on a canvas, in the colours of a layer, frame by frame.
{
  // Viridis in equal steps of lightness (after Smith and van der Walt 2015), as the SVG of fields.
  const STOPS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
  const MOST = 255;
  const palette = Array.from({ length: MOST + 1 }, (_, code) => {
    const at = (code / MOST) * (STOPS.length - 1);
    const k = Math.min(STOPS.length - 2, Math.floor(at));
    return STOPS[k].map((from, c) => Math.round(from + (at - k) * (STOPS[k + 1][c] - from)));
  });
  const css = palette.map(([r, g, b]) => `rgb(${r},${g},${b})`);
  const { motions } = JSON.parse(document.getElementById("data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const MARGIN = { left: 62, right: 14, top: 10, bottom: 44, key: 58 };
  const FRAMES_A_SECOND = 6;

  for (const place of document.querySelectorAll(".motion")) {
    const motion = motions[Number(place.dataset.motion)];
    const canvas = place.querySelector("canvas");
    const [slider, layers, views, play] = ["input.frame", "select.layer", "select.view", "button.play"].map((it) => place.querySelector(it));
    const [readout, packing] = [place.querySelector(".readout"), place.querySelector(".packing")];
    const unpacked = new Map();
    // Bytes of a layer in a frame, unpacked once.
    const codesOf = (layer, frame) => {
      const { data } = motion.layers[layer];
      const k = Math.min(frame, data.length - 1);
      const key = `${layer}/${k}`;
      if (!unpacked.has(key)) unpacked.set(key, bytes(data[k]));
      return unpacked.get(key);
    };
    const placesOf = (frame) => {
      const k = Math.min(frame, motion.points.data.length - 1);
      const key = `places/${k}`;
      if (!unpacked.has(key)) {
        const raw = bytes(motion.points.data[k]);
        const all = new Float64Array(raw.length / 2);
        const n = motion.axes.length;
        for (let i = 0; i < all.length; i++) {
          const { low, high } = motion.points.ranges[i % n];
          all[i] = low + ((high - low) * (raw[2 * i] + 256 * raw[2 * i + 1])) / 65535;
        }
        unpacked.set(key, all);
      }
      return unpacked.get(key);
    };
    const valueOf = (layer, code) => {
      const { low, high } = layer.range;
      const value = low + ((high - low) * code) / MOST;
      return layer.is_logarithmic ? 10 ** value : value;
    };
    const withUnit = (value, unit) => `${short(value)}${unit ? ` ${unit}` : ""}`;

    // Pairs of axes of a body in space.
    if (motion.axes.length === 3) {
      for (const [a, b] of [[0, 1], [0, 2], [1, 2]]) {
        views.add(new Option(`${motion.axes[a]}, ${motion.axes[b]}`, `${a}${b}`));
      }
    }
    const view = () => (motion.axes.length === 3 ? [...views.value].map(Number) : [0, 1]);
    // What a bar has upwards is the value itself.
    const isProfile = motion.points && motion.axes.length === 1;

    // Limits of the axes over all frames.
    const limits = (layer) => {
      if (motion.cells) {
        const over = (axis) => [Math.min(...motion.cells.map((it) => it[axis][0])), Math.max(...motion.cells.map((it) => it[axis][1]))];
        return [over("x"), over("y")];
      }
      const half = motion.points.spacing / 2;
      const along = ({ low, high }) => [low - half, high + half];
      const [a, b] = view();
      const value = () => {
        const { low, high } = layer.range;
        const room = 0.05 * (high - low) || Math.abs(high) || 1;
        return [low - room, high + room];
      };
      return [along(motion.points.ranges[a]), isProfile ? value() : along(motion.points.ranges[b])];
    };

    let shown = null;
    const draw = () => {
      const [l, frame] = [Number(layers.value || 0), Number(slider.value)];
      const layer = motion.layers[l];
      const codes = codesOf(l, frame);
      const [across, up] = limits(layer);
      const width = Math.max(240, canvas.clientWidth);
      const inner = width - MARGIN.left - MARGIN.right - MARGIN.key;
      // Bodies keep their proportions; planes of states have different units on their axes.
      const shape = motion.points && !isProfile ? (up[1] - up[0]) / (across[1] - across[0]) : 0.68;
      const tall = Math.min(Math.max(inner * shape, 60), 520);
      const wide = motion.points && !isProfile ? Math.min(inner, tall / shape) : inner;
      const height = tall + MARGIN.top + MARGIN.bottom;
      const ratio = window.devicePixelRatio || 1;
      canvas.style.height = `${height}px`;
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      const ctx = canvas.getContext("2d");
      ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
      const x = (value) => MARGIN.left + ((value - across[0]) / (across[1] - across[0])) * wide;
      const y = (value) => MARGIN.top + tall - ((value - up[0]) / (up[1] - up[0])) * tall;
      ctx.fillStyle = theme.colour("--panel");
      ctx.fillRect(MARGIN.left, MARGIN.top, wide, tall);
      const ground = layer.is_logarithmic ? 1 : 0;
      ctx.save();
      ctx.beginPath();
      ctx.rect(MARGIN.left, MARGIN.top, wide, tall);
      ctx.clip();
      let places = null;
      if (motion.cells) {
        const { count: [nx, ny], x: [x0, x1], y: [y0, y1] } = motion.cells[frame];
        const picture = new ImageData(nx, ny);
        codes.forEach((code, i) => {
          if (code < ground) return;
          const to = 4 * ((ny - 1 - Math.floor(i / nx)) * nx + (i % nx));
          picture.data.set([...palette[code], 255], to);
        });
        const sheet = new OffscreenCanvas(nx, ny);
        sheet.getContext("2d").putImageData(picture, 0, 0);
        ctx.imageSmoothingEnabled = false;
        ctx.drawImage(sheet, x(x0), y(y1), x(x1) - x(x0), y(y0) - y(y1));
      } else {
        places = placesOf(frame);
        const n = motion.axes.length;
        const [a, b] = view();
        const size = Math.max(1.5, (motion.points.spacing / (across[1] - across[0])) * wide);
        const order = Array.from(codes.keys());
        if (n === 3) {
          // The nearest are drawn last.
          const depth = 3 - a - b;
          order.sort((i, j) => places[n * i + depth] - places[n * j + depth]);
        }
        for (const i of order) {
          ctx.fillStyle = css[codes[i]];
          const dot = isProfile ? 3 : size;
          const top = isProfile ? valueOf(layer, codes[i]) : places[n * i + b];
          // Whole pixels, so that neighbours meet.
          const edge = Math.ceil(dot * ratio) / ratio;
          const pixel = (at) => Math.round((at - dot / 2) * ratio) / ratio;
          ctx.fillRect(pixel(x(places[n * i + a])), pixel(y(top)), edge, edge);
        }
      }
      ctx.restore();
      axes(ctx, { x, y, across, up, wide, tall, layer });
      key(ctx, { tall, width, layer });
      // The colours of all codes are those of the legend, so the extremes are those of the frame.
      let [least, most] = [0, 0];
      for (let i = 0; i < codes.length; i++) {
        if (codes[i] < codes[least]) least = i;
        if (codes[i] > codes[most]) most = i;
      }
      const name = motion.frames[frame];
      slider.setAttribute("aria-valuetext", name);
      const text = `${name}: ${layer.name} from ${layer.is_logarithmic && codes[least] < 1 ? "0" : withUnit(valueOf(layer, codes[least]), layer.unit)} to ${withUnit(valueOf(layer, codes[most]), layer.unit)}`;
      readout.textContent = text;
      packing.textContent = `Packed in ${MOST + 1} steps: ${layer.error}.`;
      shown = { layer, codes, places, frame, x, y, text };
    };

    const ticks = ([low, high], n) => {
      const raw = (high - low) / n;
      const unit = 10 ** Math.floor(Math.log10(raw));
      const step = [1, 2, 5, 10].map((k) => k * unit).find((it) => it >= raw);
      const all = [];
      for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) all.push(Number((k * step).toPrecision(12)));
      return all;
    };
    const axes = (ctx, { x, y, across, up, wide, tall, layer }) => {
      const [a, b] = view();
      const upwards = isProfile ? `${layer.name}${layer.unit ? ` (${layer.unit})` : ""}` : motion.axes[b];
      ctx.strokeStyle = theme.colour("--soft");
      ctx.strokeRect(MARGIN.left, MARGIN.top, wide, tall);
      ctx.fillStyle = theme.colour("--ink");
      ctx.font = "12px system-ui, sans-serif";
      ctx.textAlign = "center";
      for (const value of ticks(across, wide < 260 ? 3 : 6)) {
        ctx.fillRect(x(value), MARGIN.top + tall, 1, 4);
        ctx.fillText(String(value), x(value), MARGIN.top + tall + 17);
      }
      ctx.fillText(motion.axes[a], MARGIN.left + wide / 2, MARGIN.top + tall + 36);
      ctx.textAlign = "right";
      for (const value of ticks(up, tall < 140 ? 2 : 5)) {
        ctx.fillRect(MARGIN.left - 4, y(value), 4, 1);
        ctx.fillText(String(value), MARGIN.left - 7, y(value) + 4);
      }
      ctx.save();
      ctx.translate(13, MARGIN.top + tall / 2);
      ctx.rotate(-Math.PI / 2);
      ctx.textAlign = "center";
      ctx.fillText(upwards, 0, 0);
      ctx.restore();
    };
    const key = (ctx, { tall, width, layer }) => {
      const left = width - MARGIN.key - MARGIN.right + 14;
      for (let code = 0; code <= MOST; code++) {
        ctx.fillStyle = css[code];
        ctx.fillRect(left, MARGIN.top + tall * (1 - (code + 1) / (MOST + 1)), 10, tall / MOST + 1);
      }
      ctx.fillStyle = theme.colour("--ink");
      ctx.font = "11px system-ui, sans-serif";
      ctx.textAlign = "left";
      for (const part of tall < 140 ? [0, 1] : [0, 0.25, 0.5, 0.75, 1]) {
        const value = valueOf(layer, part * MOST);
        const text = layer.is_logarithmic ? value.toExponential(0).replace("e+", "e") : String(Number(value.toPrecision(3))).replace("e+", "e");
        ctx.fillText(text, left + 14, MARGIN.top + tall * (1 - part) + (part === 1 ? 9 : part === 0 ? 0 : 4));
      }
    };

    // The value under the pointer, with the error of its packing.
    const look = (event) => {
      if (!shown) return;
      const box = canvas.getBoundingClientRect();
      const [px, py] = [event.clientX - box.left, event.clientY - box.top];
      const { layer, codes, places, frame, x, y, text } = shown;
      let found = null;
      if (motion.cells) {
        const { count: [nx, ny], x: [x0, x1], y: [y0, y1] } = motion.cells[frame];
        const i = Math.floor(((px - x(x0)) / (x(x1) - x(x0))) * nx);
        const j = Math.floor(((y(y0) - py) / (y(y0) - y(y1))) * ny);
        if (i >= 0 && i < nx && j >= 0 && j < ny) found = j * nx + i;
      } else {
        const n = motion.axes.length;
        const [a, b] = view();
        let near = 12 ** 2;
        for (let i = 0; i < codes.length; i++) {
          const top = isProfile ? valueOf(layer, codes[i]) : places[n * i + b];
          const d = (x(places[n * i + a]) - px) ** 2 + (y(top) - py) ** 2;
          if (d <= near) [near, found] = [d, i];
        }
      }
      if (found === null) {
        readout.textContent = text;
        return;
      }
      const isBelow = layer.is_logarithmic && codes[found] === 0;
      const value = valueOf(layer, codes[found]);
      readout.textContent = `${motion.frames[frame]}: ${layer.name} ${isBelow ? `below ${withUnit(value, layer.unit)}` : `${withUnit(value, layer.unit)}, ${layer.error}`} under the pointer`;
    };
    canvas.addEventListener("pointermove", look);
    canvas.addEventListener("pointerleave", () => shown && (readout.textContent = shown.text));

    let timer = null;
    const stop = () => {
      clearInterval(timer);
      timer = null;
      play.textContent = "Play";
    };
    const next = () => {
      slider.value = String((Number(slider.value) + 1) % motion.frames.length);
      draw();
    };
    play.addEventListener("click", () => {
      if (timer !== null) return stop();
      play.textContent = "Pause";
      timer = setInterval(next, 1000 / FRAMES_A_SECOND);
    });
    slider.addEventListener("input", () => {
      stop();
      draw();
    });
    layers.addEventListener("change", draw);
    views.addEventListener("change", draw);
    theme.onChange(draw);
    addEventListener("resize", draw);
    draw();
  }
}
